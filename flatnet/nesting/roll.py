"""Nest copies on a roll with the strip packing engine."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.nesting.check import check_layout
from flatnet.nesting.compaction import compact
from flatnet.nesting.engine import EXACT_FIT, EngineError, Item, Placed, Strip, run_searches, separation_for
from flatnet.nesting.layout import Copy, Layout, Placement
from flatnet.nesting.orientation import fits_anyhow, fitting_rotations
from flatnet.parameters import NestingParameters
from flatnet.project.model import Material

#: Called with the part of the used length that is covered, whenever a shorter layout is found.
Denser = Callable[[float], None]
Floats = NDArray[np.float64]

#: The engine hardly finds copies that fill the width exactly: its strip is wider by this part of itself.
WIDER = 1e-4
#: mm that outlines are simplified by before they are compacted: edges below it have no direction.
SIMPLIFIED = 1e-4


def nest_on_roll(
    copies: Sequence[Copy], material: Material, parameters: NestingParameters, denser: Denser = lambda _: None
) -> list[Placement]:
    """Place all copies on as little length of the roll as the engine finds in its time, then compact them.

    What the engine lays on a strip that is a little wider need not go on the roll. Where it doesn't, the engine is
    asked once more, to keep more than the gap.

    Parameters
    ----------
    copies : every one fits on the material in an allowed rotation; copies of a piece stand together.

    Raises
    ------
    EngineError
        Where the engine panics, takes too long, or leaves copies out.
    """
    area = sum(copy.piece.area for copy in copies)
    margin = separation_for(material.gap, material.width, area)
    roll = replace(material, length=None)
    for strip in (
        Strip((1.0 + WIDER) * (material.width + 2.0 * material.gap), material.gap),
        Strip((1.0 + EXACT_FIT) * (material.width + 2.0 * margin), margin),
    ):
        found = [_compacted(laid, roll) for laid in _laid(copies, strip, material, parameters, denser)]
        valid = [layout for layout in found if not check_layout(layout)]
        if valid:
            break
    return list(min(valid or found, key=lambda layout: layout.used_length).placements)


def _laid(
    copies: Sequence[Copy], strip: Strip, material: Material, parameters: NestingParameters, denser: Denser
) -> list[list[Placement]]:
    """As searches of the engine lay the copies on a strip; the engine keeps its separation to the rim too."""
    groups, items = kinds_of(copies, material)
    area = sum(copy.piece.area for copy in copies)
    corner = np.array([strip.separation, 0.5 * (strip.width - material.width)])

    def rebuilt(answer: Placed) -> list[Placement]:
        if Counter(item for item, *_ in answer) != Counter(dict(enumerate(map(len, groups)))):
            raise EngineError("it did not place every copy once")
        left = [list(group) for group in groups]
        return [items[item].rebuilt(left[item].pop(0), rotation, place - corner) for item, rotation, place in answer]

    def told(length: float, _: Placed) -> None:
        denser(area / (material.width * (length - 2.0 * strip.separation)))

    return [rebuilt(answer) for answer in run_searches(strip, items, parameters, told)]


def _compacted(placements: Sequence[Placement], roll: Material) -> Layout:
    shifts = compact([_outline(placement) for placement in placements], roll.width, roll.gap).tolist()
    return Layout(roll, tuple(replace(p, x_mm=p.x_mm + x, y_mm=p.y_mm + y) for p, (x, y) in zip(placements, shifts)))


def _outline(placement: Placement) -> Floats:
    """The cut line where it lies, (n, 2) mm, anticlockwise, without what is below `SIMPLIFIED`."""
    region = shapely.simplify(shapely.transform(placement.piece.region, placement.place), SIMPLIFIED)
    return shapely.get_coordinates(shapely.orient_polygons(region).exterior)[:-1]


def kinds_of(copies: Sequence[Copy], material: Material) -> tuple[list[list[Copy]], list[Item]]:
    """The copies in groups that are alike, and each group as an item of the engine."""
    groups = [list(group) for _, group in groupby(copies, key=lambda copy: (copy.piece.name, copy.mirrored))]
    items = []
    for group in groups:
        copy = group[0]
        free = material.rotations is None and not copy.piece.match and fits_anyhow(copy.piece, material)
        rotations = None if free else fitting_rotations(copy.piece, copy.mirrored, material).tolist()
        items.append(Item.of(copy.piece.region, copy.mirrored, len(group), rotations))
    return groups, items
