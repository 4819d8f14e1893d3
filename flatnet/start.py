"""Project files to start from: the faces of a network listed, drawn and written down; a mesh; a first example."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flatnet.export.output import OutputError
from flatnet.forms import make_surface
from flatnet.forms.smooth_squares import smooth_squares
from flatnet.network.listing import FaceList, ListedFace, list_faces
from flatnet.project import Project, ProjectError, load_project
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
#: So many places on a mesh are tried for its first patch.
MOST_TRIED = 12
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

    Of the faces only the patch is listed and drawn: what is left of the mesh around it is no concern of a beginner's.

    Raises
    ------
    ProjectError
        The mesh can't be read.
    OutputError
        The project file exists, or can't be written.
    """
    file = Path(out)
    _refuse_existing(file)
    if mesh is not None:
        return _mesh_project(file, Path(mesh), units, up)
    project = parse_project(file, EXAMPLE)
    listed = list_faces(project, None)
    _write(file, EXAMPLE)
    return _started(project, listed, [file], file.with_name(f"{file.stem}-faces.png"), [])


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


def _mesh_project(file: Path, mesh: Path, units: str, up: str) -> Started:
    """Write a project with a patch where the mesh is smooth, or with the mesh alone where no place for one is found."""
    said = {"mesh": _quoted(os.path.relpath(mesh, file.parent or ".")), "units": units, "up": up}
    head = "\n".join(
        ["flatnet: 1", f"name: {_quoted(mesh.stem)}", "surface:", *(f"  {k}: {v}" for k, v in said.items() if v), ""]
    )
    # No project is without a curve: this one is never sampled.
    probe = parse_project(file, f"{head}edge_length: 1\ncurves: {{a: {{points: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}}}}\n")
    surface = make_surface(probe)
    assert surface is not None, "the project names a mesh"
    sizes = np.ptp(surface.mesh.bounds, axis=0)
    lines = [f"mesh: {' x '.join(f'{size:.4g}' for size in sizes)} mm, {len(surface.mesh.faces)} triangles"]
    if sizes.max() < SMALL:
        lines.append("warning: that is small; if the mesh's unit is another, say --units")
    for corners in islice(smooth_squares(surface), MOST_TRIED):
        # Edges that more than two faces share stop geodesics, but no projection.
        for kind in ("geodesic", ""):
            text = _patch_on_mesh(head, corners, kind)
            project = parse_project(file, text)
            try:
                listed = list_faces(project, surface)
            except ProjectError:
                continue
            if [face.fault for face in listed.faces if face.kind == "patch"] == [""]:
                _write(file, text)
                return _started(project, listed, [file], file.with_name(f"{file.stem}-faces.png"), lines)
    edge_length = _round(float(sizes.max()) / EDGES_ROUND)
    _write(file, f"{head}edge_length: {edge_length:g}    # mm: target length of mesh edges\n{SURFACE_ALONE}")
    lines.append(f"no smooth place for a first patch was found: draw curves on the mesh under `curves:` in {file}")
    return Started((*lines, str(file)), (file,))


#: What follows the surface where no patch is drawn on it.
SURFACE_ALONE = """\
# Points on the mesh, the ways between them on it, and the patch between those; docs/project-file.md has all kinds:
# nodes:
#   a: {at: [0, 0, 0], on: surface}    # and b, c: points near the mesh, moved to it
# curves:
#   one: {kind: geodesic, from: a, to: b}    # and two from b to c, three from c to a
# patches:
#   first: {around: [one, two, three]}
# rest: openings
materials:
  cloth: {width: 1500, gap: 3, allowance: 10}    # mm
"""


def _patch_on_mesh(head: str, corners: Floats, kind: str) -> str:
    """The project with a patch between four points of the mesh, (4, 3) mm, and curves of a kind; "": projected."""
    side = float(np.linalg.norm(corners[1] - corners[0]))
    places = [f"[{', '.join(f'{x:.6g}' for x in corner)}]" for corner in corners]
    nodes = [f"  {name}: {{at: {place}, on: surface}}" for name, place in zip("abcd", places)]
    sides = zip(("one", "two", "three", "four"), "abcd", "bcda")
    how = f"kind: {kind}" if kind else "on: surface"
    curves = [f"  {name}: {{from: {start}, to: {end}, {how}}}" for name, start, end in sides]
    drawn = "the straightest ways on the surface" if kind else "projected onto the surface"
    return "\n".join(
        [
            f"{head}edge_length: {_round(side / 10.0):g}    # mm: target length of mesh edges",
            "nodes:    # corners, moved to the nearest point of the surface",
            *nodes,
            f"curves:    # {drawn}; their normals are its own",
            *curves,
            "patches:    # faces by the loop around them, anticlockwise seen from outside",
            "  first: {around: [one, two, three, four]}",
            "rest: openings    # faces that are listed nowhere are not made",
            f"materials:\n  cloth: {{width: {_round(max(WIDTH, 4.0 * side)):g}, gap: 3, allowance: 10}}    # mm",
            "",
        ]
    )


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


def _started(
    project: Project, listed: FaceList, written: list[Path], picture: Path, about: Sequence[str] | None = None
) -> Started:
    """What is told of a project that is started: every face; or lines `about` it, and of the faces its patches."""
    lines = list(about or [])
    if about is not None:
        listed = replace(listed, faces=tuple(face for face in listed.faces if face.kind == "patch"))
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
    if about is None and written and extent < SMALL:
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
