"""Nest copies on a roll, or on one sheet of fixed length."""

from __future__ import annotations

from collections.abc import Sequence

import shapely

from flatnet.nesting.check import TOLERANCE
from flatnet.nesting.fill import fill
from flatnet.nesting.frame import nest_in_region
from flatnet.nesting.layout import Copy, Placement, left_over
from flatnet.nesting.roll import Denser, nest_on_roll
from flatnet.parameters import NestingParameters
from flatnet.project.model import Material


def nest_on_rectangle(
    copies: Sequence[Copy],
    material: Material,
    parameters: NestingParameters,
    denser: Denser = lambda _: None,
) -> list[Placement]:
    """On as little of its length as the engine finds; of a sheet, as much as it gets inside where all is too much.

    Raises
    ------
    EngineError
        Where the engine panics, takes too long, or leaves copies out.
    """
    if material.length is None:
        return nest_on_roll(copies, material, parameters, denser)
    sheet = shapely.box(0.0, 0.0, material.length, material.width)
    on_one: list[Placement] = []
    if sum(copy.piece.area for copy in copies) < sheet.area:
        on_one = within_length(nest_on_roll(copies, material, parameters, denser), material)
        if len(on_one) == len(copies):
            return on_one
    filled = nest_in_region(copies, sheet, material, parameters, denser)
    return max(
        (_with_more(copies, found, sheet, material) for found in (on_one, filled)),
        key=lambda found: sum(placement.piece.area for placement in found),
    )


def within_length(placements: Sequence[Placement], material: Material) -> list[Placement]:
    """Those that lie on the sheet."""
    limit = float("inf") if material.length is None else material.length + 0.5 * TOLERANCE
    return [p for p in placements if p.place(p.piece.cut_line)[:, 0].max() <= limit]


def _with_more(
    copies: Sequence[Copy], found: list[Placement], sheet: shapely.Polygon, material: Material
) -> list[Placement]:
    return found + fill(left_over(copies, found), sheet, found, material)
