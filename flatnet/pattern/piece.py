"""A fitted patch becomes a piece to cut: sew line, cut line, seams, grain, labels, in the flat frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from flatnet.failure import PatchFailure
from flatnet.fitting.results import FittedPatch
from flatnet.pattern.labels import Label, grain_line, name_label, seam_label
from flatnet.project.model import Material

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A corner of the cut line lies at most this many allowances from the sew line's (the trade's mitre limit).
MITRE_LIMIT = 3.5
#: Sides of a slit lie on each other up to round-off: an overlap narrower than this, mm, is none.
TOUCH = 1e-3


@dataclass(frozen=True, eq=False)
class SeamRun:
    """One seam along a piece.

    Attributes
    ----------
    vertices : (k,) int; the sew line's vertices along the seam, in the seam's own direction, so that both
        pieces of a seam count from the same end.
    label : the seam's name inside the piece; None where it fits nowhere.
    """

    seam: str
    vertices: Ints
    label: Label | None

    def __post_init__(self) -> None:
        self.vertices.setflags(write=False)


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece as it is cut and marked: mm, anticlockwise seen from the normals' side, the grain along +x.

    Attributes
    ----------
    sew_line : (n, 2) float; the flat boundary of the patch, untouched.
    cut_line : (k, 2) float; the sew line and its allowance.
    holes : (k, 2) float each, clockwise; cut out inside it: what a patch that closes on itself goes round.
    grain : (2, 2) float; the arrow's tail and head, inside the piece; None where the patch has no grain.
    label : name, copies and material, well inside the piece.
    cut, mirrored : how many plain and how many mirrored copies are cut.
    material : name of the material.
    """

    name: str
    sew_line: Floats
    cut_line: Floats
    holes: tuple[Floats, ...]
    seams: tuple[SeamRun, ...]
    grain: Floats | None
    label: Label
    cut: int
    mirrored: int
    material: str

    def __post_init__(self) -> None:
        for line in (self.sew_line, self.cut_line, *self.holes):
            line.setflags(write=False)

    @cached_property
    def region(self) -> Polygon:
        """What is inside the cut line and outside its holes."""
        return Polygon(self.cut_line, self.holes) if self.holes else region_of(self.cut_line)

    @property
    def area(self) -> float:
        """mm^2 inside the cut line."""
        return float(self.region.area)


def region_of(outline: Floats) -> Polygon:
    """The region inside a closed outline, which may touch itself along a slit.

    An outline that overlaps itself covers some of its region twice: its signed area and that of the region
    differ.

    Raises
    ------
    ValueError
        Where the outline crosses itself; says where and how much is covered twice.
    """
    polygon = Polygon(outline)
    if polygon.is_valid:
        return polygon
    slack = TOUCH * polygon.length
    repaired = shapely.get_parts(shapely.make_valid(polygon, method="structure", keep_collapsed=False))
    parts = [part for part in repaired if part.area > slack]
    difference = abs(polygon.area - sum(part.area for part in parts))
    if len(parts) != 1 or difference > slack:
        raise ValueError(f"it crosses itself ({shapely.is_valid_reason(polygon)} mm; {difference:.3g} mm^2)")
    return Polygon(parts[0].exterior, [hole for hole in parts[0].interiors if Polygon(hole).area > slack])


def offset_outline(outline: Floats, region: Polygon, allowance: float) -> tuple[Floats, tuple[Floats, ...]]:
    """The outline with a uniform allowance, mitred at corners up to `MITRE_LIMIT`, and the holes left inside it.

    A ring that is cut open and lies closed in the plane has a hole; without allowance its outline runs round
    the hole by itself. On straight parts and at convex corners the distance is exact; along inward curves GEOS
    leaves vertices out where that widens the allowance by up to 1 %, never narrows it.
    """
    if allowance == 0.0:
        return outline, ()
    grown = region.buffer(allowance, join_style="mitre", mitre_limit=MITRE_LIMIT)
    grown = shapely.orient_polygons(grown)
    slack = TOUCH * grown.length
    cut_line, *holes = (
        shapely.get_coordinates(ring)[:-1]
        for ring in (grown.exterior, *(hole for hole in grown.interiors if Polygon(hole).area > slack))
    )
    return cut_line, tuple(holes)


def make_piece(fitted: FittedPatch, material: Material) -> Piece:
    """Draw the piece of a fitted patch, with the allowance of its material.

    Raises
    ------
    PatchFailure
        `self_intersection` where the sew line overlaps itself in the plane: such a piece can't be cut.
    """
    patch, sew_line = fitted.patch, fitted.outline
    try:
        inside = region_of(sew_line)
    except ValueError as error:
        raise PatchFailure.of(
            "self_intersection", "pattern", f"the flat piece can't be cut from one sheet: {error}.",
            "Divide the patch by another curve through the place where it overlaps.", patch=patch.name,
        ) from error

    label = name_label(_text(patch.name, patch.cut, patch.mirrored, material.name), inside)
    free = inside.difference(label.box)
    seams = []
    for stretch in patch.boundary.stretches:
        along = np.arange(stretch.first, stretch.first + stretch.count + 1) % len(sew_line)
        seam = seam_label(stretch.seam, sew_line[along], free)
        if seam:
            free = free.difference(seam.box)
        seams.append(SeamRun(stretch.seam, along[::-1].copy() if stretch.reversed else along, seam))
    cut_line, holes = offset_outline(sew_line, inside, material.allowance)
    return Piece(
        name=patch.name,
        sew_line=sew_line,
        cut_line=cut_line,
        holes=holes,
        seams=tuple(seams),
        grain=grain_line(free) if fitted.has_grain else None,
        label=label,
        cut=patch.cut,
        mirrored=patch.mirrored,
        material=material.name,
    )


def _text(name: str, cut: int, mirrored: int, material: str) -> tuple[str, ...]:
    copies = f"cut {cut}" + (f" + {mirrored} mirrored" if mirrored else "")
    return (name, copies, material)
