"""Nest copies on a roll with the strip packing engine."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby

from flatnet.nesting.engine import EXACT_FIT, EngineError, Item, Strip, run_engine, separation_for
from flatnet.nesting.layout import Copy, Placement, turn
from flatnet.nesting.orientation import fits_anyhow, fitting_rotations
from flatnet.parameters import NestingParameters
from flatnet.project.model import Material

#: Called with the part of the used length that is covered, whenever a shorter layout is found.
Denser = Callable[[float], None]


def nest_on_roll(
    copies: Sequence[Copy], material: Material, parameters: NestingParameters, denser: Denser = lambda _: None
) -> list[Placement]:
    """Place all copies on as little length of the roll as the engine finds in its time.

    The engine keeps its separation to the rim too. So its strip is wider by a separation on both sides, and its
    length has one at both ends.

    Parameters
    ----------
    copies : every one fits on the material in an allowed rotation; copies of a piece stand together.

    Raises
    ------
    EngineError
        Where the engine panics, takes too long, or leaves copies out.
    """
    groups, items = kinds_of(copies, material)
    margin = EXACT_FIT * (material.width + 2.0 * material.gap)
    area = sum(copy.piece.area for copy in copies)
    separation = separation_for(material.gap, material.width, area)
    strip = Strip(material.width + 2.0 * separation + margin, separation)
    answer = run_engine(
        strip, items, parameters, lambda length, _: denser(area / (material.width * (length - 2.0 * separation)))
    )
    if Counter(item for item, *_ in answer) != Counter(dict(enumerate(map(len, groups)))):
        raise EngineError("it did not place every copy once")
    placements = []
    for item, rotation, place in answer:
        place[1] -= separation + 0.5 * margin
        placements.append(_across(items[item].rebuilt(groups[item].pop(0), rotation, place), material))
    return _from_zero(placements)


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


def _across(placement: Placement, material: Material) -> Placement:
    """The placement moved onto the roll, off which rounding may have brought it."""
    piece = placement.piece
    across = (piece.cut_line @ turn(placement.rotation_deg, placement.mirrored).T)[:, 1] + placement.y_mm
    y = placement.y_mm + max(0.0, -float(across.min())) - max(0.0, float(across.max()) - material.width)
    return replace(placement, y_mm=y)


def _from_zero(placements: list[Placement]) -> list[Placement]:
    """The layout moved along the roll to its start."""
    start = min(float(p.place(p.piece.cut_line)[:, 0].min()) for p in placements)
    return [replace(p, x_mm=p.x_mm - start) for p in placements]
