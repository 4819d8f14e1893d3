"""Folded darts: the cut line across a dart's mouth, true where the dart is folded, and the marks to sew it by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from flatnet.network.patch import Patch
from flatnet.pattern.allowance import GRID, TOUCH, CutLine, rings_of
from flatnet.pattern.marks import Mark
from flatnet.pattern.notches import Notch, way_out
from flatnet.pattern.seams import Seam
from flatnet.project.seam_specs import NotchSpec

Floats = NDArray[np.float64]

#: Gaps narrower than twice this, mm, are round-off.
HAIRLINE = 1e-6
#: The intake is filled up to this part of a dart's length from its tip; from there on the fold decides.
FILLED = 0.5


@dataclass(frozen=True, eq=False)
class Dart:
    """A slit that opens in the flat piece and is sewn closed with its intake folded to one side.

    Attributes
    ----------
    edges : the boundary edges of both legs, which have no allowance.
    tip : (2,) mm.
    under, over : (k, 2) mm, the legs from the tip to the mouth; the intake lies below the piece beside `under`.
    drill : how far the drill hole is from the tip, mm.
    """

    seam: str
    edges: NDArray[np.int64]
    under: Floats
    over: Floats
    drill: float

    @property
    def tip(self) -> Floats:
        return self.under[0]

    @property
    def middle(self) -> Floats:
        """The unit direction of the fold, from the tip out of the mouth."""
        legs = [leg[-1] - self.tip for leg in (self.under, self.over)]
        along: Floats = sum(leg / np.linalg.norm(leg) for leg in legs)
        return along / np.linalg.norm(along)

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.under[-1] - self.tip))


def find_darts(patch: Patch, sew_line: Floats, seams: Mapping[str, Seam]) -> list[Dart]:
    """The slits of a patch that are said to be darts and that open in the plane."""
    stretches = patch.boundary.stretches
    found = []
    for before, after in zip((stretches[-1], *stretches[:-1]), stretches, strict=True):
        spec = seams[after.seam].spec.dart
        if before.seam != after.seam or spec is None or after.first not in patch.boundary.slit_tips:
            continue
        numbers = after.first + np.arange(after.count + 1)
        first = sew_line[(numbers[0] - np.arange(after.count + 1)) % len(sew_line)]
        second = sew_line[numbers % len(sew_line)]
        if np.linalg.norm(first[-1] - second[-1]) <= TOUCH:
            continue
        # The stretch that runs in the curve's direction has the piece on the curve's left.
        under, over = (first, second) if (spec.fold == "left") == after.reversed else (second, first)
        edges = (after.first + np.arange(-after.count, after.count)) % len(sew_line)
        drill = min(spec.drill, 0.5 * float(np.linalg.norm(under[-1] - under[0])))
        found.append(Dart(after.seam, edges, under, over, drill))
    return found


def with_straight_legs(sew_line: Floats, darts: list[Dart]) -> Floats:
    """The outline with the legs of every dart drawn straight from mouth to tip."""
    straight = sew_line.copy()
    for dart in darts:
        count = len(dart.edges) // 2
        part = np.arange(count)[:, None] / count
        for start, end in ((0, count), (count, 2 * count)):  # the vertex at which a leg's last edge ends stays
            first, last = sew_line[dart.edges[start]], sew_line[(dart.edges[end - 1] + 1) % len(sew_line)]
            straight[dart.edges[start:end]] = first + part * (last - first)
    return straight


def fold_darts(cut: CutLine, darts: list[Dart]) -> CutLine:
    """The cut line with every dart's intake, cut as the folded dart's mouth lies under the piece.

    When the dart is closed, the half of the intake next to the leg `under` lies below the piece mirrored in that leg,
    and the other half lies there turned about the tip. So there its cut line is the piece's own, mirrored or turned
    back. Curved legs are folded along their chords.

    Parameters
    ----------
    cut : of the outline with straight legs (`with_straight_legs`).
    """
    if not darts:
        return cut
    whole = Polygon(cut.outline, cut.holes)
    parts = [whole]
    for dart in darts:
        tip = dart.tip
        far = 2.0 * float(np.linalg.norm(cut.outline - tip, axis=1).max())
        legs = [(leg[-1] - tip) / np.linalg.norm(leg[-1] - tip) for leg in (dart.under, dart.over)]
        halves = [Polygon([tip, tip + far * leg, tip + far * dart.middle]) for leg in legs]
        mirror = 2.0 * np.outer(legs[0], legs[0]) - np.eye(2)
        for half, linear in zip(halves, (mirror, _turn(legs[0], legs[1])), strict=True):
            parts.append(half.intersection(_moved(whole, linear, tip)))
        near = shapely.Point(tip).buffer(FILLED * dart.length)
        parts.append(Polygon([tip, dart.under[-1], dart.over[-1]]).intersection(near))
    # Parts that meet along a leg leave hairlines of round-off between them, which would be cut.
    closed = shapely.union_all(shapely.buffer(parts, HAIRLINE, join_style="mitre"), grid_size=GRID)
    outer, *holes = rings_of(closed.buffer(-HAIRLINE, join_style="mitre"))
    return CutLine(outer, tuple(holes), cut.crowded)


def _turn(start: Floats, end: Floats) -> Floats:
    """The rotation that takes one unit vector to another, (2, 2)."""
    cosine, sine = start @ end, start[0] * end[1] - start[1] * end[0]
    return np.array([[cosine, -sine], [sine, cosine]])


def _moved(region: shapely.Geometry, linear: Floats, centre: Floats) -> shapely.Geometry:
    return shapely.transform(region, lambda points: centre + (points - centre) @ linear.T)


def dart_marks(dart: Dart) -> list[Mark]:
    """The fold, an arrow across it to the side that the intake is folded to, and the drill hole short of the tip."""
    fold = dart.tip + np.outer([dart.drill, 0.9 * dart.length], dart.middle)
    across = np.array([-dart.middle[1], dart.middle[0]])
    side = across if across @ (dart.under[-1] - dart.tip) > 0.0 else -across
    size = 0.3 * float(np.linalg.norm(dart.under[-1] - dart.over[-1]))
    tail = dart.tip + 0.7 * dart.length * dart.middle - 0.5 * size * side
    head = tail + size * side
    barb = head - 0.3 * size * side
    arrow = np.array([tail, head, barb + 0.2 * size * dart.middle, head, barb - 0.2 * size * dart.middle])
    drill = dart.tip + dart.drill * dart.middle
    return [
        Mark(f"{dart.seam} fold", "fold", fold),
        Mark(f"{dart.seam} direction", "fold", arrow),
        Mark(f"{dart.seam} tip", "drill", drill[None]),
    ]


def dart_notches(dart: Dart, cut: CutLine) -> list[Notch]:
    """A notch at the mouth of each leg, on the cut line where the leg drawn on meets it."""
    rings = shapely.MultiLineString([[*ring, ring[0]] for ring in (cut.outline, *cut.holes)])
    notches = []
    for leg in (dart.under, dart.over):
        outward = (leg[-1] - dart.tip) / np.linalg.norm(leg[-1] - dart.tip)
        foot = way_out(leg[-1], outward, rings)
        notches.append(Notch(dart.seam, leg[-1].copy(), foot, -outward, "slit", NotchSpec.depth, 1))
    return notches
