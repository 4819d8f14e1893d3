"""The one checker that every layout passes through before it is used, whoever made it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from shapely import Polygon

from flatnet.nesting.layout import Copy, Layout, Placement, copies_of, turned_by
from flatnet.pattern.piece import Piece
from flatnet.project.hides import Hide

#: mm. Cut lines are written to 0.001 mm: what is smaller is not in the file.
TOLERANCE = 1e-3
#: Degrees. Rotations are copied from the material's list; over a piece of 10 m this is 2e-7 mm.
ROTATION_TOLERANCE = 1e-9


def check_layouts(layouts: Sequence[Layout], pieces: Sequence[Piece], left: Sequence[Copy] = ()) -> list[str]:
    """Everything that is wrong with the sheets of one material: nothing, where they may be cut.

    Checked: every copy of every piece once and no other, mirrored only where asked, allowed rotations only, those
    that are to match in one direction, inside the sheet, off the defects of a hide and in the zone that is asked
    for, no overlap, the gap kept, no more sheets than there are; lengths within `TOLERANCE`.

    Parameters
    ----------
    left : copies that are known to be missing.
    """
    problems = [*_count(layouts, pieces, left), *_match(layouts)]
    for layout in layouts:
        if layout.sheet > layout.material.count:
            problems.append(f"sheet {layout.sheet}: material '{layout.material.name}' has {layout.material.count:g}")
        else:
            problems += check_layout(layout)
    return problems


def check_layout(layout: Layout) -> list[str]:
    """What is wrong with the copies that lie on one sheet, whatever others there are."""
    problems, placed = [], []
    for placement in layout.placements:
        if not np.isfinite([placement.rotation_deg, placement.x_mm, placement.y_mm]).all():
            problems.append(f"{placement}: its place is not a number")
            continue
        region = shapely.transform(placement.piece.region, placement.place)
        placed.append((placement, region))
        problems += _rotation(placement, layout)
        problems += _inside(placement, region, layout)
    return [*problems, *_apart(placed, layout.material.gap)]


def _count(layouts: Sequence[Layout], pieces: Sequence[Piece], left: Sequence[Copy]) -> Iterator[str]:
    wanted = Counter(str(copy) for copy in copies_of(pieces))
    wanted.subtract(str(copy) for copy in left)
    found = Counter(str(placement) for layout in layouts for placement in layout.placements)
    for name in sorted(wanted | found):
        if found[name] != wanted[name]:
            yield f"{name}: placed {found[name]} times instead of {wanted[name]}"


def _rotation(placement: Placement, layout: Layout) -> Iterator[str]:
    allowed = layout.material.rotations
    if allowed is None:
        return
    if min(turned_by(placement.rotation_deg, angle) for angle in allowed) > ROTATION_TOLERANCE:
        yield f"{placement}: rotated by {placement.rotation_deg:g} degrees, allowed are {allowed}"


def _match(layouts: Sequence[Layout]) -> Iterator[str]:
    first: dict[str, Placement] = {}
    for placement in (placement for layout in layouts for placement in layout.placements):
        if not placement.piece.match:
            continue
        other = first.setdefault(placement.piece.name, placement)
        away = turned_by(placement.rotation_deg, other.rotation_deg)
        if away > ROTATION_TOLERANCE:
            yield f"{placement}: turned by {away:g} degrees against {other}, and they are to match"


def _inside(placement: Placement, region: Polygon, layout: Layout) -> Iterator[str]:
    if layout.hide is not None:
        yield from _on_hide(placement, region, layout.hide)
        return
    if placement.piece.zone:
        yield f"{placement}: asks for zone {placement.piece.zone!r}, and lies on no hide"
    left, bottom, right, top = region.bounds
    length = np.inf if layout.material.length is None else layout.material.length
    beyond = max(-left, -bottom, top - layout.material.width, right - length)
    if beyond > TOLERANCE:
        yield f"{placement}: {beyond:.3f} mm outside the sheet"


def _on_hide(placement: Placement, region: Polygon, hide: Hide) -> Iterator[str]:
    inner = region.buffer(-TOLERANCE)
    whole = Polygon(hide.outline)
    if not whole.covers(inner):
        yield f"{placement}: {shapely.hausdorff_distance(inner.union(whole), whole):.3f} mm outside the hide"
    for number, ring in enumerate(hide.defects, 1):
        if (covered := inner.intersection(Polygon(ring)).area) > 0.0:
            yield f"{placement}: covers {covered:.3g} mm^2 of defect {number}"
    if placement.piece.zone and not hide.zone(placement.piece.zone).buffer(TOLERANCE).covers(inner):
        yield f"{placement}: not inside zone {placement.piece.zone!r}"


def _apart(placed: Sequence[tuple[Placement, Polygon]], gap: float) -> Iterator[str]:
    # Each piece shrunk by half the tolerance: what still overlaps does so by more than the tolerance, and
    # touching pieces stand clear.
    regions = np.array([region for _, region in placed], dtype=object)
    shrunk = shapely.buffer(regions, -0.5 * TOLERANCE, join_style="mitre")
    first, second = shapely.STRtree(shrunk).query(shrunk, predicate="dwithin", distance=gap)
    for i, j in sorted(zip(first, second)):
        if i >= j:
            continue
        names = f"{placed[i][0]} and {placed[j][0]}"
        distance = regions[i].distance(regions[j])
        if shapely.intersects(shrunk[i], shrunk[j]):
            yield f"{names}: overlap, {regions[i].intersection(regions[j]).area:.3g} mm^2"
        elif distance < gap - TOLERANCE:
            yield f"{names}: {distance:.3f} mm apart instead of {gap:g}"
