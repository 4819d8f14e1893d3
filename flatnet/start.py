"""Project files to start from: the faces of a network listed, drawn and written down; a mesh; a first example."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flatnet.export.output import OutputError
from flatnet.forms import ReferenceSurface, make_surface
from flatnet.geometry.triangles import unit
from flatnet.network.listing import FaceList, ListedFace, list_faces
from flatnet.project import Project, load_project
from flatnet.project.drawings import READERS, DrawingError, read_drawing
from flatnet.project.loader import parse_project
from flatnet.project.values import UNITS
from flatnet.report.pictures import PictureError, draw_faces

Floats = NDArray[np.float64]

#: Edges round a face of the middle size, when a project is started.
EDGES_ROUND = 40
#: Edge length with which the faces are found for the first time, over the extent of the network.
FIRST = 1.0 / 100.0
#: Bounds of the edge length of a project that is started, over the extent of its network.
FINEST, COARSEST = 1.0 / 300.0, 1.0 / 20.0
#: A polyline whose points lie closer than this, in edge lengths, is sampled anew as a spline ...
DENSE = 0.5
#: ... unless it turns by more than this at a point, rad: a spline would round its corner.
CORNER = np.radians(30.0)
#: Extent of a drawing below which its unit is doubtful, mm.
SMALL = 20.0
#: Side of the first patch on a mesh, over the extent of the mesh.
SQUARE = 0.1
#: Width of the first material, mm, but no less than the largest face's outline is long (so that its piece fits
#: whichever way it lies), and no more than some times that.
WIDTH, LARGEST_ROLL = 1500.0, 4.0


@dataclass(frozen=True)
class DrawingOptions:
    """What a drawing does not say of itself, as words of `import`: each "" or false where nothing is said."""

    units: str = ""
    up: str = ""
    snap: str = ""
    join_crossings: bool = False


@dataclass(frozen=True, eq=False)
class Started:
    """What was found, ready to print, and the files that were written."""

    lines: tuple[str, ...]
    files: tuple[Path, ...]


def faces(source: str | Path, out: str | Path | None = None, options: DrawingOptions = DrawingOptions()) -> Started:
    """List and draw the faces of a drawing or a project; of a drawing, write a project to start from.

    Parameters
    ----------
    source : a drawing (docs/networks.md), or a project file, which stays as it is.
    out : the project file to write, `.yaml`; left out, it has the drawing's name and stands in the current folder.
        The picture stands beside it and is called `<name>-faces.png`.

    Raises
    ------
    ProjectError
        The drawing can't be read, or its faces are unsure.
    OutputError
        The project file exists, or can't be written.
    """
    source = Path(source)
    if source.suffix.lower() not in READERS:
        project = load_project(source)
        listed = list_faces(project, make_surface(project))
        picture = Path(out) if out is not None else Path(f"{source.stem}-faces.png")
        return _started(project, listed, [], picture)
    file = Path(f"{source.stem}.yaml") if out is None else Path(out)
    _refuse_existing(file)
    project, text = _drawn_project(source, file, options)
    listed = list_faces(project, None)
    _write(file, text + _faces_text(listed))
    return _started(project, listed, [file], file.with_name(f"{file.stem}-faces.png"))


def new(out: str | Path, mesh: str | Path | None = None, units: str = "", up: str = "") -> Started:
    """Write a project to start from: on a mesh, with one patch drawn on it; without, a square of cloth over a bump.

    Raises
    ------
    ProjectError
        The mesh can't be read.
    OutputError
        The project file exists, or can't be written.
    """
    file = Path(out)
    _refuse_existing(file)
    text = EXAMPLE if mesh is None else _mesh_project(file, Path(mesh), units, up)
    project = parse_project(file, text)
    listed = list_faces(project, make_surface(project))
    _write(file, text)
    return _started(project, listed, [file], file.with_name(f"{file.stem}-faces.png"))


#: A project that builds, with a word on everything in it.
EXAMPLE = """\
flatnet: 1
name: first
edge_length: 10    # mm: target length of mesh edges
nodes:    # the corners, by name
  a: [0, 0, 0]
  b: [200, 0, 0]
  c: [200, 200, 0]
  d: [0, 200, 0]
curves:    # from node to node: points in between, and the normals of the surface that is wanted
  south: {kind: spline, from: a, to: b, points: [[100, 0, 30]], normals: [0, -0.3, 1]}
  east: {from: b, to: c, normals: [0.3, 0, 1]}
  north: {kind: spline, from: c, to: d, points: [[100, 200, 30]], normals: [0, 0.3, 1]}
  west: {from: d, to: a, normals: [-0.3, 0, 1]}
patches:    # faces by the loop around them, anticlockwise seen against the normals; -south runs it backwards
  top: {around: [south, east, north, west]}
rest: openings    # faces that are listed nowhere are not made
materials:
  cloth: {width: 1500, gap: 3, allowance: 10}
"""


def _mesh_project(file: Path, mesh: Path, units: str, up: str) -> str:
    """A project with four nodes on a mesh round one of its outermost points, and the patch between them."""
    said = {"mesh": _quoted(os.path.relpath(mesh, file.parent or ".")), "units": units, "up": up}
    head = "\n".join(
        ["flatnet: 1", f"name: {_quoted(mesh.stem)}", "surface:", *(f"  {k}: {v}" for k, v in said.items() if v), ""]
    )
    # No project is without a curve: this one is never sampled.
    probe = parse_project(file, f"{head}edge_length: 1\ncurves: {{a: {{points: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}}}}\n")
    surface = make_surface(probe)
    assert surface is not None, "the project names a mesh"
    corners = _flattest_square(surface, *surface.mesh.bounds)
    side = float(np.linalg.norm(corners[1] - corners[0]))
    places = [f"[{', '.join(f'{x:.6g}' for x in corner)}]" for corner in corners]
    nodes = [f"  {name}: {{at: {place}, on: surface}}" for name, place in zip("abcd", places)]
    sides = zip(("one", "two", "three", "four"), "abcd", "bcda")
    curves = [f"  {name}: {{from: {start}, to: {end}, on: surface}}" for name, start, end in sides]
    return "\n".join(
        [
            f"{head}edge_length: {_round(side / 10.0):g}    # mm: target length of mesh edges",
            "nodes:    # corners, moved to the nearest point of the surface",
            *nodes,
            "curves:    # projected onto the surface; their normals are its own",
            *curves,
            "patches:    # faces by the loop around them, anticlockwise seen from outside",
            "  first: {around: [one, two, three, four]}",
            "rest: openings    # faces that are listed nowhere are not made",
            f"materials:\n  cloth: {{width: {_round(max(WIDTH, 4.0 * side)):g}, gap: 3, allowance: 10}}    # mm",
            "",
        ]
    )


def _flattest_square(surface: ReferenceSurface, low: Floats, high: Floats) -> Floats:
    """Corners of a square on a surface, anticlockwise seen from outside, where its normals differ least, (4, 3) mm.

    Tried round the points nearest to the middles of its bounding box's sides.
    """
    side = SQUARE * float((high - low).max())
    sides = np.concatenate([np.eye(3), -np.eye(3)]) * 0.5 * (high - low) + 0.5 * (low + high)
    middles, normals = surface.nearest(sides)
    best, agreement = np.zeros((4, 3)), -np.inf
    for middle, normal in zip(middles, normals):
        x = unit(np.cross(np.eye(3)[np.abs(normal).argmin()], normal))
        y = np.cross(normal, x)
        corners, around = surface.nearest(middle + 0.5 * side * np.array([-x - y, x - y, x + y, y - x]))
        lengths = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
        agrees = float((around @ normal).min()) + float(lengths.min()) / side  # beyond an edge corners fall together
        if agrees > agreement:
            best, agreement = corners, agrees
    return best


def _drawn_project(source: Path, file: Path, options: DrawingOptions) -> tuple[Project, str]:
    """The project of a drawing and its text, without faces."""
    said = {"file": _quoted(os.path.relpath(source, file.parent or ".")), "units": options.units, "up": options.up}
    said |= {"snap": options.snap, "join": "crossings" if options.join_crossings else ""}
    imported = [f"  {key}: {value}" for key, value in said.items() if value]

    def text(edge_length: float, *more: str) -> str:
        return "\n".join(
            [
                "flatnet: 1",
                f"name: {_quoted(source.stem)}",
                f"edge_length: {edge_length:g}    # mm: target length of mesh edges",
                "import:",
                *imported,
                *more,
                "  normals: curves    # from the curves' tangents; give curves normals of their own under `curves:`",
                "",
            ]
        )

    trim = "  trim: true    # what ends inside a face is left out"
    extent = _extent(source, options.units)
    network = list_faces(parse_project(file, text(_round(FIRST * extent), trim)), None)
    perimeter = float(np.median([face.length for face in network.faces]))
    edge_length = _round(float(np.clip(perimeter / EDGES_ROUND, FINEST * extent, COARSEST * extent)))
    project = parse_project(file, text(edge_length, trim))
    more = [trim] if any(finding.code == "trimmed_end" for finding in project.findings) else []
    if _is_dense(project, edge_length):
        more.append("  kind: spline    # its points lie closer than edge_length: sampled anew along a smooth curve")
    final = text(edge_length, *more)
    return parse_project(file, final), final


def _extent(source: Path, units: str) -> float:
    """Of a drawing, mm; 1 where it or its unit can't be read, of which the project's loader says more."""
    try:
        points = np.concatenate([curve.points for curve in read_drawing(source)])
        return float(np.ptp(points, axis=0).max()) * (UNITS.get(units) or float(units or 1.0))
    except (DrawingError, ValueError):
        return 1.0


def _is_dense(project: Project, edge_length: float) -> bool:
    """Whether the polylines' points are much closer than the edges wanted, and none has a corner."""
    steps = []
    for curve in project.curves.values():
        if curve.kind == "spline":
            continue
        entries = [curve.start, *curve.points, curve.end]
        points = np.array([project.nodes[e].position if isinstance(e, str) else e for e in entries if e is not None])
        chords = np.diff(points, axis=0)
        lengths = np.linalg.norm(chords, axis=1)
        steps += lengths.tolist()
        turns = np.einsum("ij,ij->i", chords[1:], chords[:-1]) / (lengths[1:] * lengths[:-1])
        if (turns < np.cos(CORNER)).any():
            return False
    return bool(steps) and float(np.median(steps)) < DENSE * edge_length


def _round(value: float) -> float:
    """To two significant digits."""
    return float(f"{value:.1e}")


def _quoted(text: str) -> str:
    """As YAML reads it back."""
    if re.fullmatch(r"[A-Za-z_./][\w./-]*", text):
        return text
    return "'" + text.replace("'", "''") + "'"


def _faces_text(listed: FaceList) -> str:
    """The sections `patches`, `openings` and `materials`: a patch of every face that can be made."""
    sections = []
    for title, chosen in (
        ("patches", [face for face in listed.faces if not face.fault]),
        ("openings", [face for face in listed.faces if face.fault]),
    ):
        if chosen:
            sections += [f"{title}:", *(_face_line(face) for face in chosen)]
    largest = max(face.length for face in listed.faces)
    width = _round(float(np.clip(WIDTH, largest, LARGEST_ROLL * largest)))
    material = f"  cloth: {{width: {width:g}, gap: {width / 500.0:g}, allowance: 0}}    # mm"
    return "\n".join([*sections, "materials:", material, ""])


def _face_line(face: ListedFace) -> str:
    fault = f"; {face.fault}" if face.fault else ""
    return f"  {face.name}: {{around: {face.around}}}    # {face.length:.4g} mm around{fault}"


def _started(project: Project, listed: FaceList, written: list[Path], picture: Path) -> Started:
    lines = []
    for kind, title in (("patch", "patches, listed:"), ("opening", "openings, listed:")):
        known = [face for face in listed.faces if face.kind == kind]
        lines += [title, *map(_face_line, known)] if known else []
    for title, wanted in (("patches:", False), ("openings:", True)):
        new = [face for face in listed.faces if not face.kind and bool(face.fault) == wanted]
        lines += [title, *map(_face_line, new)] if new else []
    lines += [f"warning {finding}" for finding in project.findings]
    if listed.parts > 1:
        lines.append(
            f"warning: the network has {listed.parts} parts that no curve joins: a loop may be a face by itself, or "
            "one of several loops of a face, around: [[...], [...]]"
        )
    extent = float(np.ptp(np.concatenate([face.outline for face in listed.faces]), axis=0).max())
    if written and extent < SMALL:
        lines.append(f"warning: the drawing is {extent:.3g} mm across; if its unit is another, say --units")
    try:
        written = [*written, draw_faces(listed, picture)]
    except PictureError as error:
        lines.append(f"no picture: {error}")
    count = len(listed.faces)
    lines.append(f"{project.name}: {count} face{'s' * (count != 1)}")
    return Started((*lines, *map(str, written)), tuple(written))


def _refuse_existing(file: Path) -> None:
    if file.suffix.lower() not in (".yaml", ".yml"):
        raise OutputError(f"{file}: a project file ends in .yaml")
    if os.path.lexists(file):
        raise OutputError(f"{file}: exists already; name another file")
    if not file.parent.is_dir():
        raise OutputError(f"{file}: there is no folder {str(file.parent)!r}")


def _write(file: Path, text: str) -> None:
    try:
        with file.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except OSError as error:
        raise OutputError(f"{file}: can't be written: {error.strerror}") from None
