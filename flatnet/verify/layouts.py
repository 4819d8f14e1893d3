"""Check the drawings: true scale, every copy once, as its flat mesh is, where the report says, apart from others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.verify.build import PIECES, Findings, WrittenBuild, WrittenPiece
from flatnet.verify.drawing import Drawing, DrawnPiece, read_drawing
from flatnet.verify.measured import APART, DRAWN, RIGID, ROTATION, Measured
from flatnet.verify.mesh import aligned, farthest
from flatnet.verify.sheets import ROUNDED, Sheet, check_inside, check_sheet, sheet_of
from flatnet.verify.written import REPORT, DamagedError, Record, WrittenFiles

Floats = NDArray[np.float64]

STORED = "layout.json"
#: Side of the square that is drawn to measure the scale, mm.
TEST_SQUARE = 50.0
#: Of a sew line that is mirrored across its fold, from its mesh's: round-off, mm.
MIRRORED = 1e-9


def check_layouts(files: WrittenFiles, build: WrittenBuild, findings: Findings) -> None:
    """All sheets, the single pieces, and the stored placements."""
    sheets: list[Sheet] = []
    with findings.guarded():
        for record in build.report.records("layouts"):
            with findings.guarded():
                drawing = read_drawing(record.text("file"), files.text(record.text("file")))
                sheets.append(sheet_of(record, build, drawing))
    findings += _check_copies(sheets, build)
    findings += _check_numbers(sheets)
    for sheet in sheets:
        findings += _check_page(sheet.file, sheet.drawing)
        with findings.guarded():
            findings += check_sheet(sheet)
        for piece in sheet.drawing.pieces:
            with findings.guarded():
                listed = build.piece(piece.patch, sheet.material_name)
                findings += _check_piece(piece, listed, build)
                findings += _check_place(piece, sheet)
                findings += check_inside(piece, listed, sheet)
        with findings.guarded():
            findings += _check_apart(sheet)
    findings += _check_matches(sheets, build)
    shown = {(sheet.material_name, piece.patch): piece for sheet in sheets for piece in sheet.drawing.pieces}
    for listed in build.pieces:
        with findings.guarded():
            drawing = read_drawing(listed.file, files.text(listed.file))
            findings += _check_page(listed.file, drawing)
            findings += _check_single(listed, drawing, shown.get((listed.material, listed.patch)), build)
        if listed.fold is not None:
            with findings.guarded():
                findings += _check_half(files, listed)
    with findings.guarded():
        findings += _check_stored(files, sheets)


def _check_copies(sheets: Sequence[Sheet], build: WrittenBuild) -> Iterator[Measured]:
    """Every copy once on the sheets of its material, plain ones before mirrored ones; none where a patch failed."""
    wanted: Counter[tuple[str, str]] = Counter()
    for piece in build.pieces:
        for number in range(1, piece.cut + piece.mirrored + 1):
            mirrored = " (mirrored)" if number > piece.cut else ""
            wanted[piece.material, f"{piece.patch} copy {number}{mirrored}"] += 1
    unlaid = {(piece.material, f"{piece.patch} copy ") for piece in build.pieces if piece.patch in build.failed}
    drawn = Counter((sheet.material_name, str(piece)) for sheet in sheets for piece in sheet.drawing.pieces)
    of_material = {name: [sheet.file for sheet in sheets if sheet.material_name == name] for name in build.materials}
    for material, copy in sorted(wanted | drawn):
        many, asked = drawn[material, copy], wanted[material, copy]
        if not many and any(material == other and copy.startswith(start) for other, start in unlaid):
            continue
        file = ", ".join(of_material.get(material, ())) or REPORT
        yield Measured("copies", file, copy, float(abs(many - asked)), 0.0, words=f"drawn {many} times, wanted {asked}")


def _check_numbers(sheets: Sequence[Sheet]) -> Iterator[Measured]:
    """No sheet of a material is used twice."""
    used = Counter((sheet.material_name, sheet.number) for sheet in sheets)
    for sheet in sheets:
        many = used[sheet.material_name, sheet.number]
        words = f"sheet {sheet.number} of '{sheet.material_name}' has {many} layouts"
        yield Measured("every sheet once", REPORT, sheet.file, float(many - 1), 0.0, words=words)


def _check_page(file: str, drawing: Drawing) -> Iterator[Measured]:
    """One unit of the drawing is 1 mm."""
    words = "width and height are not those of the viewBox"
    yield Measured("one unit is 1 mm", file, "", drawing.off_scale, 0.0, "mm", words)
    squares = drawing.lines.get("test-square", [])
    sizes = [float(np.abs(np.ptp(square.points, axis=0) - TEST_SQUARE).max()) for square in squares]
    off = max(sizes, default=np.nan)
    yield Measured("test square", file, "", off, 2.0 * ROUNDED, "mm", f"its side is not {TEST_SQUARE:g} mm")


def _check_piece(piece: DrawnPiece, listed: WrittenPiece, build: WrittenBuild) -> Iterator[Measured]:
    """Its sew line is the flat outline of its patch, turned and moved, and mirrored where it says so."""
    file, name = piece.file, str(piece)
    off = float(np.abs(piece.linear.T @ piece.linear - np.eye(2)).max())
    yield Measured("pieces neither stretched nor sheared", file, name, off, RIGID, words="its matrix")
    # SVG is y down: to be seen from the normals' side, a plain copy is flipped.
    turned_over = float((np.linalg.det(piece.linear) > 0.0) != piece.mirrored)
    yield Measured("mirrored as it says", file, name, turned_over, 0.0, words="its matrix shows the other side")
    patch = build.patches.get(piece.patch)
    if patch is None:
        raise DamagedError(file, f"{name}: there is no mesh of this patch")
    if patch.mesh.faults:
        return
    outline, drawn = listed.outline_of(patch.mesh), piece.sew_line
    if len(outline) != len(drawn):
        words = f"its sew line has {len(drawn)} vertices, the boundary of {patch.file} {len(outline)}"
        more = float(abs(len(drawn) - len(outline)))
        yield Measured("sew line is the flat outline", file, name, more, 0.0, words=words)
        return
    linear, shift = aligned(outline, drawn, mirrored=not piece.mirrored)
    off = farthest(outline @ linear.T + shift, drawn)
    yield Measured("sew line is the flat outline", file, name, off, DRAWN, "mm", f"not congruent with {patch.file}")
    sewn = shapely.Polygon(drawn) if len(drawn) > 2 else shapely.Polygon()
    outside = shapely.difference(shapely.boundary(sewn), shapely.buffer(piece.region, DRAWN))
    words = "so much of the sew line lies outside the cut line"
    yield Measured("sew line inside the cut line", file, name, float(outside.length), 0.0, "mm", words)
    for line in piece.lines.get("grain", [])[:1]:
        along = line.points[1] - line.points[0]
        across = float(abs(along[1]))
        yield Measured("grain along x", file, name, across, 2.0 * ROUNDED, "mm", "of the piece's own frame")


def _rotation(piece: DrawnPiece) -> float:
    """In which it lies, degrees."""
    turn = np.diag([1.0, -1.0]) @ piece.linear @ np.diag([1.0, -1.0 if piece.mirrored else 1.0])
    return float(np.degrees(np.arctan2(turn[1, 0], turn[0, 0])))


def _check_matches(sheets: Sequence[Sheet], build: WrittenBuild) -> Iterator[Measured]:
    """All copies of a piece that is to match lie in one direction."""
    for listed in build.pieces:
        if not listed.match:
            continue
        of_material = [sheet for sheet in sheets if sheet.material_name == listed.material]
        copies = [piece for sheet in of_material for piece in sheet.drawing.pieces if piece.patch == listed.patch]
        for piece in copies:
            off = _away(_rotation(piece), _rotation(copies[0]))
            yield Measured("copies that match", piece.file, str(piece), off, ROTATION, "deg", f"against {copies[0]}")


def _check_place(piece: DrawnPiece, sheet: Sheet) -> Iterator[Measured]:
    """It lies where the report says, in an allowed rotation."""
    file, name, material = sheet.file, str(piece), sheet.material
    rotation = _rotation(piece)
    if material.rotations is not None:
        off = min(_away(rotation, angle) for angle in material.rotations.tolist())
        words = f"it is turned by {rotation:.6g} degrees, which the material does not allow"
        yield Measured("rotations allowed", file, name, off, ROTATION, "deg", words)
    found = [
        record
        for record in sheet.record.records("pieces")
        if (record.text("patch"), record.count("copy"), record.flag("mirrored"))
        == (piece.patch, piece.copy, piece.mirrored)
    ]
    yield Measured("copies of the report", REPORT, f"{file}, {name}", float(abs(len(found) - 1)), 0.0)
    if len(found) == 1:
        angle = np.radians(found[0].number("rotation_deg"))
        spun = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        linear = np.diag([1.0, -1.0]) @ spun @ np.diag([1.0, -1.0 if piece.mirrored else 1.0])
        shift = [found[0].number("x_mm"), sheet.width - found[0].number("y_mm")]
        own = piece.lines["sew"][0].points
        off = farthest(own @ linear.T + shift, piece.sew_line)
        yield Measured("pieces where the report says", file, name, off, DRAWN, "mm", "drawn elsewhere")


def _check_apart(sheet: Sheet) -> Iterator[Measured]:
    """No two copies overlap, and the gap is kept."""
    pieces, gap = sheet.drawing.pieces, sheet.material.gap
    regions = np.array([piece.region for piece in pieces], dtype=object)
    shrunk = shapely.buffer(regions, -0.5 * APART, join_style="mitre")
    first, second = shapely.STRtree(regions).query(regions, predicate="dwithin", distance=gap)
    near = sorted((i, j) for i, j in zip(first.tolist(), second.tolist()) if i < j)
    yield Measured("neighbours on sheets", sheet.file, "", 0.0, 0.0, words=f"{len(near)} pairs")
    for i, j in near:
        both = f"{pieces[i]} and {pieces[j]}"
        if shapely.intersects(shrunk[i], shrunk[j]):
            area = float(regions[i].intersection(regions[j]).area)
            yield Measured("no overlap", sheet.file, both, area, 0.0, "mm^2", "they overlap")
        else:
            short = max(gap - float(regions[i].distance(regions[j])), 0.0)
            yield Measured("gap kept", sheet.file, both, short, APART, "mm", f"the gap of {gap:g} mm lacks")


def _check_single(
    listed: WrittenPiece, drawing: Drawing, on_sheet: DrawnPiece | None, build: WrittenBuild
) -> Iterator[Measured]:
    """The drawing of a piece alone shows it once, plain, and cut as it is on the sheet."""
    one = [(piece.patch, piece.mirrored) for piece in drawing.pieces] == [(listed.patch, False)]
    words = f"it shows {', '.join(map(str, drawing.pieces)) or 'no piece'}"
    yield Measured("one piece alone", listed.file, listed.patch, float(not one), 0.0, words=words)
    if not one:
        return
    (piece,) = drawing.pieces
    yield from _check_piece(piece, listed, build)
    yield from _check_listed(listed, piece, build)
    if on_sheet is None:
        return
    for kind in ("cut", "sew", "notch", "nick", "internal", "grain"):
        alone, laid = ([line.points for line in one.lines.get(kind, [])] for one in (piece, on_sheet))
        off = _farthest_of_all(alone, laid)
        words = f"its path '{kind}' is another than in {on_sheet.file}"
        yield Measured("piece alone as on the sheet", listed.file, listed.patch, off, 2.0 * ROUNDED, "mm", words)


def _check_half(files: WrittenFiles, listed: WrittenPiece) -> Iterator[Measured]:
    """What is cut on folded cloth is the patch's own half."""
    file = f"pieces/{listed.name}_on_fold.svg"
    drawing = read_drawing(file, files.text(file))
    yield from _check_page(file, drawing)
    halves = [line.points for piece in drawing.pieces for line in piece.lines.get("sew", [])]
    off = _farthest_of_all([listed.half], halves)
    words = f"not the half that is in {PIECES}"
    yield Measured("halves on the fold", file, listed.name, off, 2.0 * ROUNDED, "mm", words)


def _check_listed(listed: WrittenPiece, piece: DrawnPiece, build: WrittenBuild) -> Iterator[Measured]:
    """pieces.json has the lines that are drawn, and the sew line that the mesh has."""
    wanted = {"sew": [listed.sew_line], "cut": [listed.cut_line, *listed.holes], **listed.lines}
    for kind, lines in wanted.items():
        drawn = [line.points for line in piece.lines.get(kind, [])]
        if kind == "grain":
            drawn = drawn[:1]  # its arrow heads follow
        off = _farthest_of_all(lines, drawn)
        words = f"its {kind} line is another than in {piece.file}"
        yield Measured("pieces as they are drawn", PIECES, listed.name, off, 2.0 * ROUNDED, "mm", words)
    patch = build.patches.get(listed.patch)
    if patch is not None and not patch.mesh.faults:
        off = _farthest_of_all([listed.sew_line], [listed.outline_of(patch.mesh)])
        allowed = 0.0 if listed.fold is None else MIRRORED
        yield Measured("sew lines bit by bit", PIECES, listed.name, off, allowed, "mm", f"off the `vt` of {patch.file}")


def _farthest_of_all(lines: Sequence[Floats], others: Sequence[Floats]) -> float:
    """The largest distance of a point from its partner; nan where they have not as many."""
    alike = [len(line) for line in lines] == [len(line) for line in others]
    return max(map(farthest, lines, others), default=0.0) if alike else np.nan


def _check_stored(files: WrittenFiles, sheets: Sequence[Sheet]) -> Iterator[Measured]:
    """layout.json, which the next build uses, holds the placements of the report."""
    layouts = Record(STORED, files.json(STORED)).record("layouts")
    stored = [sheet for digest in layouts.names() for sheet in layouts.record(digest).lists("sheets")]
    for sheet in sheets:
        if not sheet.record.flag("draft"):
            absent = float(sheet.record.lists("pieces") not in stored)
            yield Measured("placements stored", STORED, sheet.file, absent, 0.0, words="not those of the report")


def _away(first: float, second: float) -> float:
    """The distance of two angles on the circle, degrees."""
    return abs((first - second + 180.0) % 360.0 - 180.0)
