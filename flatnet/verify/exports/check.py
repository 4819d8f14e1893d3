"""Check the exports that a build's report lists: every line as in pieces.json, every model as the meshes."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from io import StringIO
from itertools import groupby
from pathlib import PurePosixPath

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.verify.build import PIECES, Findings, WrittenBuild, WrittenPiece
from flatnet.verify.drawing import DrawnLine, read_drawing
from flatnet.verify.exports.dxf import DxfContent, read_dxf
from flatnet.verify.exports.hpgl import ROUNDED, read_hpgl
from flatnet.verify.exports.lines import WantedLine, drawn_line, found_elsewhere, nearest, of_piece, of_sheet
from flatnet.verify.exports.models import Model, read_glb, read_ply
from flatnet.verify.exports.pdf import read_pdf
from flatnet.verify.measured import Measured
from flatnet.verify.mesh import aligned, farthest
from flatnet.verify.written import DamagedError, Record, WrittenFiles

Floats = NDArray[np.float64]

#: An export changes no coordinate by more, mm; drawings and formats with fewer digits say so themselves.
EXACT = 1e-3
#: Of single precision, relative to the largest coordinate: rounding, and adding what was rounded.
SINGLE = 4.0 * float(np.finfo(np.float32).eps)
#: What a piece has beside its outlines, as `WrittenPiece.lines` has it.
OTHERS = {"notch": "notches", "nick": "nicks", "internal": "marks", "grain": "grain"}
#: Layers of the trade's DXF.
LAYERS = {"sew": ("14",), "cut": ("1", "11"), "internal": ("8",), "grain": ("7",)}
NOTCH_LAYERS, DRILL_LAYER = ("4", "80", "81"), "13"
#: Pens of HPGL.
PENS = {"cut": "1", "sew": "2", "notch": "3", "nick": "1", "internal": "4", "grain": "5"}
#: Files of a build that are no exports.
OWN = ("patches/", "pieces/")

Check = Callable[[WrittenFiles, str, WrittenBuild], Iterator[Measured]]


def check_exports(files: WrittenFiles, build: WrittenBuild, findings: Findings) -> None:
    """All listed files of a format that is known, but for the build's own."""
    with findings.guarded():
        layouts = {record.text("file") for record in build.report.records("layouts")}
        for name in sorted(build.report.texts("files")):
            check = _check_of(name)
            if check is not None and name not in layouts and not name.startswith(OWN):
                with findings.guarded():
                    findings += check(files, name, build)


def _check_of(name: str) -> Check | None:
    if name.endswith("_specification.json"):
        return _garmentcode
    return CHECKS.get(PurePosixPath(name).suffix) or NAMED.get(PurePosixPath(name).name)


def _lines(
    file: str,
    kind: str,
    wanted: Sequence[WantedLine],
    drawn: dict[str, list[DrawnLine]],
    allowed: float,
    moved: bool = False,
) -> Iterator[Measured]:
    """Every line is drawn, on the layer of its meaning where the format has layers (else all are under "").

    Parameters
    ----------
    moved : a copy may lie elsewhere; where, its sew line tells.
    """
    for subject, lines in groupby(wanted, lambda line: line.subject):
        linear, shift = np.eye(2), np.zeros(2)
        worst: dict[str, float] = {}
        for line in lines:
            among = drawn.get(line.kind, drawn.get("", []))
            if moved and line.kind == "sew":
                off, linear, shift = found_elsewhere(line.line, among)
            else:
                off = nearest(line.moved(subject, linear, shift).line, among)
            if line.kind in OTHERS:
                worst[line.kind] = max(off, worst.get(line.kind, 0.0))
                continue
            words = f"its {line.kind} line is not that of {PIECES}"
            yield Measured(f"{kind}: outlines", file, subject, off, allowed, "mm", words)
        for other, off in worst.items():
            words = f"not all are where {PIECES} has them"
            yield Measured(f"{kind}: {OTHERS[other]}", file, subject, off, allowed, "mm", words)
    if "" not in drawn:
        yield from _as_many(file, kind, wanted, drawn)


def _as_many(
    file: str, kind: str, wanted: Sequence[WantedLine], drawn: dict[str, list[DrawnLine]]
) -> Iterator[Measured]:
    """No layer has a line too many; but that of the grain has arrow heads, and outlines may share theirs with nicks."""
    for meaning, lines in drawn.items():
        if meaning == "grain":
            continue
        has = sum(line.closed for line in lines) if meaning in ("sew", "cut") else len(lines)
        many = sum(line.kind == meaning for line in wanted)
        what = "outlines" if meaning in ("sew", "cut") else OTHERS[meaning]
        words = f"{has} {meaning} lines instead of {many}"
        yield Measured(f"{kind}: as many {what}", file, meaning, float(abs(has - many)), 0.0, words=words)


def _sheet_of(file: str, build: WrittenBuild) -> Record:
    """The layout that an export is of: that with the longest name with which its own begins."""
    stem = PurePosixPath(file).stem
    found = [
        (len(name), record)
        for record in build.report.records("layouts")
        for name in [PurePosixPath(record.text("file")).stem]
        if stem == name or stem.startswith(f"{name}-")
    ]
    if not found:
        raise DamagedError(file, "is of no layout of the report")
    return max(found, key=lambda pair: pair[0])[1]


def _svg(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    drawing = read_drawing(file, files.text(file))
    words = "width and height are not those of the viewBox"
    yield Measured("SVG: one unit is 1 mm", file, "", drawing.off_scale, 0.0, "mm", words)
    drawn: dict[str, list[DrawnLine]] = {kind: [] for kind in ("sew", "cut", *OTHERS)}
    for piece in drawing.pieces:
        for kind, lines in drawn.items():
            for line in piece.lines.get(kind, []):
                on_page = line.points @ piece.linear.T + piece.shift
                lines.append(drawn_line(on_page @ np.diag([1.0, -1.0]), line.closed))
    alone = [piece for piece in build.pieces if file.endswith(piece.file)]
    wanted = of_piece(alone[0]) if alone else of_sheet(_sheet_of(file, build), build)
    yield from _lines(file, "SVG", wanted, drawn, EXACT, moved=True)


def _dxf(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    content = read_dxf(file, files.text(file))
    return _dxf_pieces(file, content, build) if len(content.blocks) > 1 or "" not in content.blocks else _dxf_sheet(
        file, content, build
    )


def _dxf_sheet(file: str, content: DxfContent, build: WrittenBuild) -> Iterator[Measured]:
    layers = content.blocks[""].lines
    drawn = {kind: layers.get(kind, []) for kind in ("sew", "cut", *OTHERS)}
    yield from _lines(file, "DXF", of_sheet(_sheet_of(file, build), build), drawn, EXACT)


def _dxf_pieces(file: str, content: DxfContent, build: WrittenBuild) -> Iterator[Measured]:
    """A block for every piece, in its own frame."""
    (sew_layer,) = LAYERS["sew"]
    blocks = [block for block in content.blocks.values() if sew_layer in block.lines]
    more = float(abs(len(blocks) - len(build.pieces)))
    words = f"{len(blocks)} blocks with a sew line, and {len(build.pieces)} pieces"
    yield Measured("DXF of the trade: blocks", file, "", more, 0.0, words=words)
    drawn = {
        kind: [line for block in blocks for layer in layers for line in block.lines.get(layer, [])]
        for kind, layers in LAYERS.items()
    }
    wanted = [
        line for piece in build.pieces for line in of_piece(piece) if line.kind in drawn and not _cross(line, piece)
    ]
    yield from _lines(file, "DXF of the trade", wanted, drawn, EXACT)
    for layers, what, places in (
        (NOTCH_LAYERS, "notches", [place for piece in build.pieces for place in _on_cut_line(piece)]),
        ((DRILL_LAYER,), "drill holes", [place for piece in build.pieces for place in piece.drills]),
    ):
        points = [point for block in blocks for layer in layers for point in block.points.get(layer, [])]
        yield from _points(file, what, places, points)


def _cross(line: WantedLine, piece: WrittenPiece) -> bool:
    """Whether a line is one of the two of the cross at a point, in place of which the trade has a drill hole."""
    ends = line.line.points
    return len(ends) == 2 and any(farthest(ends.mean(axis=0)[None], place[None]) <= EXACT for place in piece.drills)


def _on_cut_line(piece: WrittenPiece) -> list[Floats]:
    """Where notches and nicks begin, as the trade has it: marks that stand side by side each on the line itself."""
    rings = shapely.MultiLineString([[*line, line[0]] for line in (piece.cut_line, *piece.holes)])
    feet = shapely.points(np.reshape(piece.feet, (-1, 2)))
    return list(shapely.get_coordinates(shapely.line_interpolate_point(rings, shapely.line_locate_point(rings, feet))))


def _points(file: str, what: str, wanted: Sequence[Floats], drawn: Sequence[Floats]) -> Iterator[Measured]:
    """Places that the trade has as points, and no others."""
    more = float(abs(len(drawn) - len(wanted)))
    words = f"{len(drawn)} {what} instead of {len(wanted)}"
    yield Measured(f"DXF of the trade: as many {what}", file, "", more, 0.0, words=words)
    if wanted:
        off = max(min((farthest(place[None], point[None]) for point in drawn), default=np.inf) for place in wanted)
        words = f"not all are where {PIECES} has them"
        yield Measured(f"DXF of the trade: {what}", file, "", off, EXACT, "mm", words)


def _hpgl(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    pens = read_hpgl(file, files.text(file))
    drawn = {kind: pens.get(pen, []) for kind, pen in PENS.items()}
    drawn["nick"] = [line for line in drawn["nick"] if not line.closed]
    yield from _lines(file, "HPGL", of_sheet(_sheet_of(file, build), build), drawn, ROUNDED)


def _pdf(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    """Its lines have no names: they are looked for on all pages, wherever a copy lies there."""
    try:
        pages = read_pdf(file, files.content(file))
    except ImportError:
        words = "pypdf is not installed, so it was not looked into: pip install pypdf"
        yield Measured("PDF: outlines", file, "", 1.0, 0.0, words=words)
        return
    drawn = {"": [line for page in pages for line in page]}
    yield from _lines(file, "PDF", of_sheet(_sheet_of(file, build), build), drawn, EXACT, moved=True)


def _same_model(kind: str, file: str, name: str, model: Model, whole: Model, allowed: float) -> Iterator[Measured]:
    """A model against the meshes of the build; its flat shape may lie elsewhere."""
    sizes = len(model.vertices) == len(whole.vertices) and np.array_equal(model.triangles, whole.triangles)
    words = "not as many vertices, or other triangles"
    yield Measured(f"{kind}: the same mesh", file, name, float(not sizes), 0.0, words=words)
    if sizes:
        off = farthest(model.vertices, whole.vertices)
        yield Measured(f"{kind}: in space", file, name, off, allowed, "mm", "off the mesh")
        linear, shift = aligned(whole.flat, model.flat)
        off = farthest(whole.flat @ linear.T + shift, model.flat)
        yield Measured(f"{kind}: flat", file, name, off, allowed, "mm", "off the `vt`")


def _single(*arrays: Floats) -> float:
    """What rounding to single precision may change, mm."""
    return min(SINGLE * max(float(np.abs(array).max()) for array in arrays), EXACT)


def _whole(file: str, build: WrittenBuild) -> Model:
    """All patches as one mesh, in the order of the report."""
    meshes = [patch.mesh for patch in build.patches.values()]
    if not meshes:
        raise DamagedError(file, "there is no mesh to compare it with")
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Model(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.flat for mesh in meshes]),
        np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts)]),
    )


def _glb(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    models = read_glb(file, files.content(file))
    yield from _patches_of("GLB", file, models, build)


def _patches_of(kind: str, file: str, models: dict[str, Model], build: WrittenBuild) -> Iterator[Measured]:
    odd = sorted(set(models) ^ set(build.patches))
    yield Measured(f"{kind}: its patches", file, "", float(len(odd)), 0.0, words=f"{', '.join(odd)}")
    for name in sorted(set(models) & set(build.patches)):
        mesh, model = build.patches[name].mesh, models[name]
        allowed = _single(model.vertices, model.flat)
        yield from _same_model(kind, file, name, model, Model(mesh.vertices, mesh.flat, mesh.triangles), allowed)


def _ply(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    model, whole = read_ply(file, files.content(file)), _whole(file, build)
    yield from _same_model("PLY", file, "", model, whole, _single(whole.vertices, whole.flat))


def _obj(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    mesh = files.mesh(file)
    yield from _same_model("OBJ", file, "", Model(mesh.vertices, mesh.flat, mesh.triangles), _whole(file, build), EXACT)


def _sewing(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    """The same seams as the report, with the same vertices and the lengths of the flat pieces."""
    seams = {record.text("name"): record for record in Record(file, files.json(file)).records("seams")}
    reported = {record.text("curve"): record for record in build.report.records("seams")}
    odd = sorted(set(seams) ^ set(reported))
    yield Measured("sewing map: its seams", file, "", float(len(odd)), 0.0, words=", ".join(odd))
    for name in sorted(set(seams) & set(reported)):
        sides, others = seams[name].records("sides"), reported[name].records("sides")
        alike = [(s.text("patch"), s.indices("vertices").tolist()) for s in sides] == [
            (s.text("patch"), s.indices("vertices").tolist()) for s in others
        ]
        words = "its sides are not those of the report"
        yield Measured("sewing map: sides", file, name, float(not alike), 0.0, words=words)
        for side in sides:
            patch = build.patches.get(side.text("patch"))
            if patch is None or not alike:
                continue
            ends = patch.mesh.flat[side.indices("vertices")]
            along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])
            said = side.numbers("arclengths")
            off = float(np.abs(said - along).max()) if len(said) == len(along) else np.inf
            yield Measured("sewing map: arclengths", file, f"{patch.name} along '{name}'", off, EXACT, "mm")


def _garmentcode(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    """Panels in cm congruent with the sew lines; edges that are stitched together equally long."""
    pattern = Record(file, files.json(file)).record("pattern")
    panels = {name: pattern.record("panels").record(name) for name in pattern.record("panels").names()}
    ends = {}
    for name, panel in panels.items():
        vertices = 10.0 * panel.numbers("vertices", 2)
        ends[name] = vertices[np.array([edge.indices("endpoints") for edge in panel.records("edges")])]
        wanted = [outline for piece in build.pieces if piece.patch == name for outline in of_piece(piece)[:1]]
        yield from _lines(file, "GarmentCode", wanted[:1], {"": [DrawnLine(vertices, True)]}, EXACT, moved=True)
    for number, stitch in enumerate(pattern.record_lists("stitches")):
        lengths = []
        for side in stitch:
            name, edge = side.text("panel"), side.count("edge")
            if name not in ends or not 0 <= edge < len(ends[name]):
                raise DamagedError(file, f"stitch {number} names edge {edge} of '{name}', which is not there")
            lengths.append(float(np.linalg.norm(np.diff(ends[name][edge], axis=0))))
        off = max(lengths) - min(lengths)
        yield Measured("GarmentCode: stitched edges", file, f"stitch {number}", off, EXACT, "mm", "not equally long")


def _cut_list(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    """As many copies as pieces.json has."""
    rows = list(csv.DictReader(StringIO(files.text(file).removeprefix("\ufeff"))))
    for piece in build.pieces:
        found = [row for row in rows if row.get("piece") == piece.name]
        counts = [(row.get("material"), row.get("cut"), row.get("mirrored")) for row in found]
        wanted = [(piece.material, str(piece.cut), str(piece.mirrored))]
        words = f"it says {counts}, wanted {wanted}"
        yield Measured("cut list: copies", file, piece.name, float(counts != wanted), 0.0, words=words)
    yield Measured("cut list: rows", file, "", float(abs(len(rows) - len(build.pieces))), 0.0)


def _material_list(files: WrittenFiles, file: str, build: WrittenBuild) -> Iterator[Measured]:
    """A row for every layout, with as many copies."""
    rows = list(csv.DictReader(StringIO(files.text(file).removeprefix("\ufeff"))))
    said = [(row.get("file"), row.get("material"), row.get("copies")) for row in rows]
    wanted = [
        (PurePosixPath(record.text("file")).stem, record.text("material"), str(len(record.records("pieces"))))
        for record in build.report.records("layouts")
    ]
    words = f"it says {said}, wanted {wanted}"
    yield Measured("material list", file, "", float(said != wanted), 0.0, words=words)


#: Ending of a file -> what checks it.
CHECKS: dict[str, Check] = {
    ".svg": _svg,
    ".dxf": _dxf,
    ".plt": _hpgl,
    ".pdf": _pdf,
    ".glb": _glb,
    ".ply": _ply,
    ".obj": _obj,
}
#: Name of a file -> what checks it.
NAMED: dict[str, Check] = {"sewing.json": _sewing, "cut-list.csv": _cut_list, "materials.csv": _material_list}
