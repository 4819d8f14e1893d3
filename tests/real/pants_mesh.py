"""A project drawn on a real mesh: a pair of trousers cut into four panels, waist and ankles open."""

from __future__ import annotations

from pathlib import Path

import networkx as nx
import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from flatnet.forms.mesh_file import read_mesh
from flatnet.project.model import MeshSurface
from flatnet.project.problems import Mark

Floats = NDArray[np.float64]

CLOTHES = Path(__file__).parents[3] / "shared" / "data" / "pants" / "female_casualsuit01.obj"

# Heights, mm, at which side seams, inside-leg, centre front and centre back are drawn; the crotch is at -85.
HIP_HEIGHTS = (35.0, -5.0, -45.0)
LEG_HEIGHTS = (-160.0, -240.0, -340.0, -440.0, -540.0, -640.0)

PATCHES = {
    "front_left": "[-waist, centre_front, inseam_left, ankle_left, -side_left]",
    "back_left": "[-waist, side_left, ankle_left, -inseam_left, -centre_back]",
    "front_right": "[-waist, side_right, ankle_right, -inseam_right, -centre_front]",
    "back_right": "[-waist, centre_back, inseam_right, ankle_right, -side_right]",
}


def pants_project(folder: Path) -> Path:
    """Write the trousers' mesh and a project on it into `folder`; the path of the project file.

    Skips the test where the clothes' mesh is not at hand. The figure faces -y, its left is +x.
    """
    if not CLOTHES.is_file():
        pytest.skip(f"real input is absent: {CLOTHES}")
    _save_trousers(folder / "trousers.obj")
    mesh = read_mesh(MeshSurface(folder / "trousers.obj", 100.0, "y", "outside", Mark(1, 1))).mesh
    waist, *ankles = sorted(_rims(mesh), key=lambda rim: -rim[:, 2].mean())
    left, right = sorted(ankles, key=lambda rim: -rim[:, 0].mean())
    crotch = _hit(mesh, np.array([0.0, -40.0, 0.0]), [0.0, 0.0, -1.0])

    nodes = {"crotch": crotch}
    curves = {
        "waist": _loop(waist, {"front": -1j, "left": 1, "back": 1j, "right": -1}, "waist", nodes),
        "ankle_left": _loop(left, {"outer": 1, "inner": -1}, "left", nodes),
        "ankle_right": _loop(right, {"inner": 1, "outer": -1}, "right", nodes),
    }
    for name, toward in (("front", [0.0, -1.0, 0.0]), ("back", [0.0, 1.0, 0.0])):
        points = [_hit(mesh, _centre(mesh, z), toward) for z in HIP_HEIGHTS]
        curves[f"centre_{name}"] = _seam(f"waist_{name}", points, "crotch")
    for side, sign in (("left", 1.0), ("right", -1.0)):
        centres = [_centre(mesh, z, sign) for z in LEG_HEIGHTS]
        outer = [_hit(mesh, _centre(mesh, z), [sign, 0.0, 0.0]) for z in HIP_HEIGHTS]
        outer += [_hit(mesh, centre, [sign, 0.0, 0.0]) for centre in centres]
        inner = [_hit(mesh, centre, [-sign, 0.0, 0.0]) for centre in centres]
        curves[f"side_{side}"] = _seam(f"waist_{side}", outer, f"{side}_outer")
        curves[f"inseam_{side}"] = _seam("crotch", inner, f"{side}_inner")

    file = folder / "project.yaml"
    file.write_text(
        "flatnet: 1\nname: trousers\nunits: mm\nedge_length: 20\n"
        "surface: {mesh: trousers.obj, units: dm, up: y}\n"
        + _section("nodes", {name: _vector(place) for name, place in nodes.items()})
        + _section("curves", curves)
        + _section("patches", {name: f"{{around: {around}}}" for name, around in PATCHES.items()})
        + _section(
            "openings",
            {
                "waist": "{around: [waist]}",
                "left_ankle": "{around: [-ankle_left]}",
                "right_ankle": "{around: [-ankle_right]}",
            },
        )
        + "materials:\n  denim: {width: 1500, rotations: [0, 180], gap: 3, allowance: 10}\nnesting: {seconds: 1}\n",
        encoding="utf-8",
    )
    return file


def _save_trousers(file: Path) -> None:
    """The second largest connected part of the clothes, as it is: 1 unit = 1 dm, y up."""
    clothes = trimesh.load_mesh(CLOTHES, process=False)
    joined = trimesh.Trimesh(clothes.vertices, clothes.faces, process=False)
    joined.merge_vertices()
    parts = sorted(joined.split(only_watertight=False), key=lambda part: -len(part.vertices))
    parts[1].export(file)


def _rims(mesh: trimesh.Trimesh) -> list[Floats]:
    """The boundary loops, each running anticlockwise seen from above."""
    edges, counts = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
    graph = nx.Graph(edges[counts == 1].tolist())
    rims = []
    for part in sorted(nx.connected_components(graph), key=min):
        loop = [edge[0] for edge in nx.find_cycle(graph.subgraph(part), source=min(part))]
        rim = np.array(mesh.vertices[loop])
        x, y = rim[:, 0] - rim[:, 0].mean(), rim[:, 1] - rim[:, 1].mean()
        area = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
        rims.append(rim if area > 0 else rim[::-1])
    return rims


def _loop(rim: Floats, directions: dict[str, complex], name: str, nodes: dict[str, Floats]) -> str:
    """A closed polyline through all vertices of a rim; nodes are those nearest to the directions."""
    bearing = np.angle((rim[:, 0] - rim[:, 0].mean()) + 1j * (rim[:, 1] - rim[:, 1].mean()))
    entries = [_vector(vertex) for vertex in rim]
    chosen = []
    for direction, toward in directions.items():
        index = int(np.argmin(np.abs(np.angle(np.exp(1j * bearing) / toward))))
        nodes[f"{name}_{direction}"] = rim[index]
        entries[index] = f"{name}_{direction}"
        chosen.append(index)
    first = chosen[0]
    around = entries[first:] + entries[:first]
    return f"{{from: {around[0]}, to: {around[0]}, points: [{', '.join(around[1:])}]}}"


def _centre(mesh: trimesh.Trimesh, height: float, side: float = 0.0) -> Floats:
    """The middle of the section at a height: of the body, or of the leg on the side of this sign."""
    cut = trimesh.intersections.mesh_plane(mesh, [0.0, 0.0, 1.0], [0.0, 0.0, height]).reshape(-1, 3)
    if side:
        cut = cut[cut[:, 0] * side > 0]
        return (cut.min(axis=0) + cut.max(axis=0)) / 2
    return np.array([0.0, (cut[:, 1].min() + cut[:, 1].max()) / 2, height])


def _hit(mesh: trimesh.Trimesh, start: Floats, toward: list[float]) -> Floats:
    """Where a ray from inside the mesh first meets it."""
    places, _, _ = mesh.ray.intersects_location([start], [toward])
    return places[np.argmin(np.linalg.norm(places - start, axis=1))]


def _seam(start: str, points: list[Floats], end: str) -> str:
    drawn = ", ".join(_vector(point) for point in points)
    return f"{{kind: spline, on: surface, from: {start}, to: {end}, points: [{drawn}]}}"


def _vector(place: Floats) -> str:
    return f"[{', '.join(f'{value:.6f}' for value in place)}]"


def _section(title: str, entries: dict[str, str]) -> str:
    return f"{title}:\n" + "".join(f"  {name}: {entry}\n" for name, entry in entries.items())
