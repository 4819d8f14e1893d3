"""What pieces lie on: a length of a roll, a sheet, or a hide with defects and quality zones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.verify.build import PIECES, WrittenBuild, WrittenHide, WrittenMaterial, WrittenPiece
from flatnet.verify.drawing import Drawing, DrawnPiece
from flatnet.verify.measured import APART, DRAWN, Measured
from flatnet.verify.written import REPORT, DamagedError, Record

Floats = NDArray[np.float64]

#: Half of the last digit of a drawing, mm.
ROUNDED = 0.0005 + 1e-9
#: utilisation is a figure of the cut lines, which are drawn rounded; relative.
UTILISATION = 1e-4


@dataclass(frozen=True, eq=False)
class Sheet:
    """A layout of the report with its drawing.

    Attributes
    ----------
    number : which sheet or hide of its material it is, from 1; of hides that took no piece there is no layout.
    """

    file: str
    number: int
    material_name: str
    material: WrittenMaterial
    record: Record
    drawing: Drawing

    @property
    def hide(self) -> WrittenHide | None:
        """What the pieces lie on, where that is no rectangle."""
        hides = self.material.hides
        return hides[self.number - 1] if self.number <= len(hides) else None

    @property
    def width(self) -> float:
        """Of the page's sheet, mm: from its y, which runs up, to that of the page, which runs down."""
        return self.hide.width if self.hide else self.material.width

    @cached_property
    def outline(self) -> Floats:
        """(k, 2) mm, y up: all of a hide, the used length of a roll."""
        if self.hide is not None:
            return self.hide.outline
        length = self.record.number("used_length_mm")
        return np.array([[0.0, 0.0], [length, 0.0], [length, self.width], [0.0, self.width]])

    def on_page(self, points: Floats) -> Floats:
        """Points of the sheet as the page shows them."""
        return points * [1.0, -1.0] + [0.0, self.width]


def sheet_of(record: Record, build: WrittenBuild, drawing: Drawing) -> Sheet:
    """The sheet of a layout of the report."""
    name, file = record.text("material"), record.text("file")
    if name not in build.materials:
        raise DamagedError(REPORT, f"{file}: there is no material '{name}' in {PIECES}")
    number = record.count("sheet")
    if number < 1:
        raise DamagedError(REPORT, f"{file}: is sheet {number} of '{name}', and they count from 1")
    return Sheet(file, number, name, build.materials[name], record, drawing)


def check_sheet(sheet: Sheet) -> Iterator[Measured]:
    """Its size and outline, that there are so many, and the figures of the report."""
    record, material, file = sheet.record, sheet.material, sheet.file
    width, length = record.number("sheet_width_mm"), record.number("used_length_mm")
    yield Measured("sheet width", REPORT, file, abs(width - sheet.width), 0.0, "mm", "not that of its material")
    if sheet.hide is None:
        over = max(length - material.length, 0.0)
        yield Measured("sheet length", REPORT, file, over, APART, "mm", "more than there is")
    over = max(sheet.number - material.count, 0.0)
    yield Measured("as many sheets as there are", REPORT, file, over, 0.0, words=f"there are {material.count:g}")
    wanted = {"sheet": [sheet.outline]}
    if sheet.hide is not None:
        wanted |= {"defect": list(sheet.hide.defects), "zone": [ring for _, ring in sheet.hide.zones]}
    for kind, rings in wanted.items():
        drawn = [shapely.LinearRing(line.points) for line in sheet.drawing.lines.get(kind, []) if line.closed]
        places = [shapely.LinearRing(sheet.on_page(ring)) for ring in rings]
        pairs = zip(places, drawn)
        alike = len(places) == len(drawn)
        off = max((float(shapely.hausdorff_distance(*pair)) for pair in pairs), default=0.0) if alike else np.nan
        yield Measured("sheet drawn", file, "", off, 2.0 * ROUNDED, "mm", f"its outline '{kind}' is another")
    regions = [piece.region for piece in sheet.drawing.pieces]
    used = max((region.bounds[2] for region in regions), default=0.0)
    yield Measured("figures of layouts", REPORT, f"{file}, used_length_mm", abs(used - length), DRAWN, "mm")
    whole = shapely.Polygon(sheet.outline).area
    part = sum(region.area for region in regions) / whole if whole else np.nan
    off = abs(part - record.number("utilisation")) / part if part else np.nan
    yield Measured("figures of layouts", REPORT, f"{file}, utilisation", off, UTILISATION)


def check_inside(piece: DrawnPiece, listed: WrittenPiece, sheet: Sheet) -> Iterator[Measured]:
    """A copy lies inside its sheet, off the defects of a hide, in the zone that it asks for."""
    file, name = sheet.file, str(piece)
    beyond = _beyond(piece.region, shapely.Polygon(sheet.on_page(sheet.outline)))
    yield Measured("inside the sheet", file, name, beyond, APART, "mm", "beyond its edge")
    if sheet.hide is not None:
        inner = shapely.buffer(piece.region, -APART, join_style="mitre")
        for number, ring in enumerate(sheet.hide.defects, start=1):
            covered = float(inner.intersection(shapely.Polygon(sheet.on_page(ring))).area)
            yield Measured("off the defects", file, name, covered, 0.0, "mm^2", f"it covers defect {number}")
    if listed.zone:
        zones = sheet.hide.zones if sheet.hide else ()
        rings = [shapely.Polygon(sheet.on_page(ring)) for zone, ring in zones if zone == listed.zone]
        beyond = _beyond(piece.region, shapely.union_all(rings)) if rings else np.nan
        yield Measured("in its zone", file, name, beyond, APART, "mm", f"outside zone '{listed.zone}'")


def _beyond(region: shapely.Polygon, room: shapely.Geometry) -> float:
    """How far a region reaches out of its room, mm."""
    outside = shapely.difference(region, room)
    return float(shapely.distance(shapely.points(shapely.get_coordinates(outside)), room).max(initial=0.0))
