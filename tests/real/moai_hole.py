"""The hole in a statue's back (the paper's second example), cut into a real scan."""

from pathlib import Path

import networkx as nx
import numpy as np
import pytest
import trimesh
import yaml

DATA = Path(__file__).parents[3] / "shared" / "data" / "moai" / "SimplifiedMoai.obj"
MM_PER_UNIT = 4900


def hole_of_the_statue():
    """Ring of mesh vertices round an hourglass over the lower back and the base, with the normals next to it.

    Returns
    -------
    ring : (n, 3), anticlockwise seen from outside.
    normals : (n, 3); of the triangle that remains on the other side of every ring edge, as in the paper.
    """
    if not DATA.exists():
        pytest.skip(f"the statue mesh is not there: {DATA}")
    mesh = trimesh.load(DATA, process=False, force="mesh")
    x, y, _ = mesh.triangles_center.T
    half_width = 0.10 + 0.10 * ((y - 0.60) / 0.3) ** 2
    removed = (np.abs(x - 1.03) < half_width) & (y < 0.88) & (mesh.face_normals[:, 2] > -0.3)
    pairs = mesh.face_adjacency[removed[mesh.face_adjacency].all(axis=1)]
    piece = max(nx.connected_components(nx.from_edgelist(pairs.tolist())), key=len)
    removed[:] = False
    removed[list(piece)] = True
    # Fill islands: what remains is the largest connected part of the rest.
    pairs = mesh.face_adjacency[(~removed)[mesh.face_adjacency].all(axis=1)]
    rest = max(nx.connected_components(nx.from_edgelist(pairs.tolist())), key=len)
    removed[:] = True
    removed[list(rest)] = False
    following, normal_of = {}, {}
    outside = {edge: face for face in np.flatnonzero(~removed) for edge in directed_edges(mesh.faces[face])}
    for face in np.flatnonzero(removed):
        for tail, head in directed_edges(mesh.faces[face]):
            if (head, tail) in outside:
                assert tail not in following, "the rim touches itself"
                following[tail] = head
                normal_of[tail] = mesh.face_normals[outside[head, tail]]
    start = min(following)
    ring = [start]
    while following[ring[-1]] != start:
        ring.append(following[ring[-1]])
    assert len(ring) == len(following), "the hole has one rim"
    return mesh.vertices[ring], np.array([normal_of[vertex] for vertex in ring])


def directed_edges(face):
    a, b, c = face
    return (a, b), (b, c), (c, a)


def moai_project(folder: Path) -> Path:
    """A project file with the hole as a closed curve and one normal per segment."""
    ring, normals = hole_of_the_statue()
    project = {
        "flatnet": 1,
        "name": "moai",
        "units": MM_PER_UNIT,
        "edge_length": 0.05,  # longer than any edge of the ring: no edge is divided
        "curves": {
            "rim": {
                "closed": True,
                "points": ring.tolist(),
                "normals": {"per": "segment", "values": normals.tolist()},
            }
        },
        "patches": {
            "back": {"around": ["rim"], "material": "sheet", "grain": [0, 1, 0], "edge_length": 0.0227}
        },
        "rest": "openings",
        "materials": {"sheet": {"width": 1.0, "gap": 0.002, "allowance": 0.004}},
    }
    file = folder / "project.yaml"
    file.write_text(yaml.safe_dump(project), encoding="utf-8")
    return file
