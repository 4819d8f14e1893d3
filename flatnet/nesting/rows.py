"""Lay copies in plain rows across the sheet: the last resort, and all that a single copy needs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flatnet.nesting.layout import Copy, Placement, turn
from flatnet.nesting.orientation import extents, fitting_rotations
from flatnet.project.model import Material


def lay_in_rows(copies: Sequence[Copy], material: Material) -> list[Placement]:
    """Bounding boxes side by side across the sheet, row after row along it, the longest first.

    Each copy takes the fitting rotation that needs the least length. The same input gives the same layout.
    """
    boxes = []
    for copy in copies:
        rotations = fitting_rotations(copy.piece, copy.mirrored, material)
        size = extents(copy.piece, copy.mirrored, rotations)
        best = int(np.argmin(np.round(size[:, 0], 6)))  # the first of equal ones, whatever the round-off
        boxes.append((copy, float(rotations[best]) % 360.0, size[best]))
    boxes.sort(key=lambda box: -round(box[2][0], 6))  # stable: equal ones stay in order

    placements = []
    row = across = depth = 0.0
    for copy, rotation, (length, width) in boxes:
        if across > 0.0 and across + width > material.width:
            row, across, depth = row + depth + material.gap, 0.0, 0.0
        corner = (copy.piece.cut_line @ turn(rotation, copy.mirrored).T).min(axis=0)
        x, y = (row, across) - corner
        placements.append(Placement(copy.piece, copy.number, copy.mirrored, rotation, float(x), float(y)))
        across += width + material.gap
        depth = max(depth, length)
    return placements
