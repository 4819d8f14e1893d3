"""Nest copies inside any region, a sheet or a hide, with the strip packing engine.

The engine knows strips only, and no item of it can be fixed. But one that is as wide as the strip can only move along
it. So the region is given to it as such an item: a frame round it, with a mouth on one side, because the engine sees
outer rings only, and with its defects joined to the rim by walls. Pieces that have no room in the frame go beside it;
as the engine makes the strip as short as it can, it brings as many as it can inside.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Point, Polygon

from flatnet.nesting.check import TOLERANCE
from flatnet.nesting.engine import EXACT_FIT, Item, Placed, Strip, run_engine, separation_for
from flatnet.nesting.layout import Copy, Placement
from flatnet.nesting.roll import Denser, kinds_of
from flatnet.parameters import NestingParameters
from flatnet.project.model import Material

Region: TypeAlias = Polygon | MultiPolygon

#: mm that the region may be simplified by, inwards.
SIMPLIFIED = 0.2
#: Width of the walls that join defects to the rim, mm.
WALL = 0.5
#: Thickness of the frame, and width of its mouth, as parts of the region's extent; the engine closes narrow mouths.
THICKNESS, MOUTH = 0.03, 0.015
#: The engine is offered pieces of this part of the region's area at the most: what lies beside the frame costs time.
OFFERED = 1.0


def nest_in_region(
    copies: Sequence[Copy],
    region: Region,
    material: Material,
    parameters: NestingParameters,
    denser: Denser = lambda _: None,
) -> list[Placement]:
    """Those of the copies that the engine gets inside the region in its time; they may be any number of them.

    Parameters
    ----------
    copies : of these, sets are offered before further sets; what is too much for the region is not looked at.
    denser : called with the part of the region's area that is covered, whenever a shorter strip is found.

    Raises
    ------
    EngineError
        Where the engine panics or takes too long.
    """
    offered = _offered(copies, region)
    if not offered:
        return []
    groups, items = kinds_of(offered, material)
    area = sum(copy.piece.area for copy in offered)
    extent = np.ptp(shapely.get_coordinates(region), axis=0)
    separation = separation_for(material.gap, float(extent.max()), area)
    frame = _frame(region, separation)
    around = Item.of(frame)
    width = float(np.ptp(frame.exterior.xy[1]))
    strip = Strip((width + 2.0 * separation) * (1.0 + EXACT_FIT), separation)

    def inside(answer: Placed) -> list[Placement]:
        origin = next(place for item, _, place in answer if item == len(items)) - around.centre
        left = [list(group) for group in groups]
        laid = [
            items[item].rebuilt(left[item].pop(0), rotation, place - origin)
            for item, rotation, place in answer
            if item < len(items)
        ]
        return [placement for placement in laid if lies_inside(placement, region)]

    def told(_: float, answer: Placed) -> None:
        denser(sum(placement.piece.area for placement in inside(answer)) / region.area)

    return inside(run_engine(strip, [*items, around], parameters, told))


def lies_inside(placement: Placement, region: Region) -> bool:
    """Whether a piece lies in a region, by the checker's tolerance."""
    placed = shapely.transform(placement.piece.region, placement.place)
    return bool(region.covers(placed.buffer(-TOLERANCE)))


def _offered(copies: Sequence[Copy], region: Region) -> list[Copy]:
    """As many as may fit, those of a kind together."""
    room = OFFERED * region.area
    chosen = []
    for copy in _in_sets(copies):
        room -= copy.piece.area
        if room < 0.0:
            break
        chosen.append(copy)
    names = list(dict.fromkeys(copy.piece.name for copy in chosen))
    return sorted(chosen, key=lambda copy: (names.index(copy.piece.name), copy.mirrored, copy.number))


def _in_sets(copies: Sequence[Copy]) -> list[Copy]:
    """First the first copies of all pieces, then the second ones ...; a mirrored copy goes with its plain one."""
    return sorted(copies, key=lambda copy: copy.number - (copy.piece.cut if copy.mirrored else 0))


def _frame(region: Region, separation: float) -> Polygon:
    """A simple polygon round the region, in a box.

    Pieces keep their separation to the frame too, which they need not to the rim: the region is wider by it, but
    not round its defects, which may be small.
    """
    left, bottom, right, top = region.bounds
    margin = THICKNESS * max(right - left, top - bottom) + 2.0 * separation
    box = shapely.box(left - margin, bottom - margin, right + margin, top + margin)
    inner = shapely.simplify(region.buffer(-SIMPLIFIED), SIMPLIFIED)
    rim = shapely.union_all([Polygon(part.exterior) for part in shapely.get_parts(inner)])
    holes = rim.difference(inner)
    solid = box.difference(rim.buffer(separation, join_style="mitre", mitre_limit=2.0))
    solid = _joined([*shapely.get_parts(solid), *shapely.get_parts(holes)])
    return _opened(solid, max(MOUTH * max(right - left, top - bottom), 3.0 * separation))


def _joined(parts: Sequence[Polygon]) -> Polygon:
    """The first part and all others, each joined by a wall to the nearest that is joined already."""
    solid: Polygon = max(parts, key=lambda part: Polygon(part.exterior).area)
    rest = [part for part in parts if part is not solid]
    while rest:
        nearest = min(rest, key=solid.distance)
        rest.remove(nearest)
        wall = LineString(shapely.shortest_line(nearest, solid)).buffer(WALL)
        solid = shapely.union_all([solid, nearest, wall])
    return solid


def _opened(solid: Polygon, width: float) -> Polygon:
    """Without holes: a mouth leads from a corner of the box to the nearest place of each."""
    while len(solid.interiors):
        hole = max((Polygon(ring) for ring in solid.interiors), key=lambda ring: ring.area)
        corners = [Point(place) for place in shapely.box(*solid.bounds).exterior.coords[:-1]]
        mouth = LineString(shapely.shortest_line(min(corners, key=hole.distance), hole)).buffer(0.5 * width)
        solid = max(shapely.get_parts(solid.difference(mouth)), key=lambda part: part.area)
    return solid
