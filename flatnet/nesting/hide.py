"""Nest copies on a hide: what asks for a quality zone first, the others as near to its start as they go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import shapely

from flatnet.nesting.fill import fill
from flatnet.nesting.frame import Region, nest_in_region
from flatnet.nesting.layout import Copy, Placement, left_over
from flatnet.nesting.roll import Denser
from flatnet.parameters import NestingParameters
from flatnet.project.hides import Hide
from flatnet.project.model import Material

#: Densities at which fewer copies than fill a hide are tried to be laid, on as much of it from its start as that takes.
DENSITIES = (0.7, 0.6, 0.5)
#: Part of the engine's time for each of these.
TIME_PART = 0.5


def nest_on_hide(
    copies: Sequence[Copy],
    hide: Hide,
    material: Material,
    parameters: NestingParameters,
    denser: Denser = lambda _: None,
) -> list[Placement]:
    """Those of the copies that go on a hide, by what the engine finds in its time.

    Raises
    ------
    EngineError
        Where the engine panics or takes too long.
    """
    placed: list[Placement] = []
    for zone in sorted({copy.piece.zone for copy in copies} - {""}):
        region = hide.zone(zone)
        placed += _filled(_asking(copies, zone), region, placed, material, parameters, denser)
    return placed + _compact(_asking(copies, ""), hide.region, placed, material, parameters, denser)


def lay_on_hide(copies: Sequence[Copy], hide: Hide, material: Material) -> list[Placement]:
    """The same one by one, without the engine: the last resort."""
    placed: list[Placement] = []
    for zone in sorted({copy.piece.zone for copy in copies}, reverse=True):
        region = hide.zone(zone) if zone else hide.region
        placed += fill(_asking(copies, zone), region, placed, material)
    return placed


def _asking(copies: Sequence[Copy], zone: str) -> list[Copy]:
    return [copy for copy in copies if copy.piece.zone == zone]


def _compact(
    copies: Sequence[Copy],
    region: Region,
    placed: Sequence[Placement],
    material: Material,
    parameters: NestingParameters,
    denser: Denser,
) -> list[Placement]:
    """All copies on a part of the region from its start, where they are few; else what all of it takes."""
    area = sum(copy.piece.area for copy in copies)
    taken = sum(placement.piece.area for placement in placed)
    hurried = replace(parameters, seconds=max(1, round(TIME_PART * parameters.seconds)))
    for density in DENSITIES:
        if area + taken < density * region.area:
            part = _start_of(region, (area + taken) / density)
            found = _filled(copies, part, placed, material, hurried, denser)
            if len(found) == len(copies):
                return found
    return _filled(copies, region, placed, material, parameters, denser)


def _start_of(region: Region, area: float) -> Region:
    """The part of a region up to the x where it has an area, by bisection."""
    left, bottom, right, top = region.bounds
    low, high = left, right
    while high - low > 1e-3 * (right - left):
        middle = 0.5 * (low + high)
        if region.intersection(shapely.box(left, bottom, middle, top)).area < area:
            low = middle
        else:
            high = middle
    return region.intersection(shapely.box(left, bottom, high, top))


def _filled(
    copies: Sequence[Copy],
    region: Region,
    placed: Sequence[Placement],
    material: Material,
    parameters: NestingParameters,
    denser: Denser,
) -> list[Placement]:
    """Those that the engine gets into the region beside what is placed, and those that then still find room."""
    if not copies or region.is_empty:
        return []
    free = region
    if placed:
        bodies = [shapely.transform(p.piece.region, p.place) for p in placed]
        # Narrow ways between them are closed: nothing goes there.
        taken = shapely.union_all(bodies).buffer(2.0 * material.gap + 1.0).buffer(-material.gap - 1.0)
        free = region.difference(taken)
    largest = max(shapely.get_parts(free), key=lambda part: part.area)
    found = nest_in_region(copies, largest, material, parameters, denser)
    return found + fill(left_over(copies, found), region, [*placed, *found], material)
