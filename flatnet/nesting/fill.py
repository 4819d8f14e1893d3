"""Lay copies one by one where there is room: what the engine left over, and the last resort on hides.

Bottom-left on a grid: the free places of a copy in a rotation are those where no cell that it covers is taken, all
found at once by a correlation (FFT); the first of them along the sheet that also holds in exact geometry is taken.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from flatnet.nesting.check import TOLERANCE
from flatnet.nesting.layout import Copy, Placement, turn
from flatnet.nesting.orientation import fitting_rotations
from flatnet.project.model import Material

Floats = NDArray[np.float64]

#: Cells along the longer side of a region.
CELLS = 500
#: Places of a copy in a rotation that are tried in exact geometry.
TRIED = 12
#: Rotations tried at the most.
ROTATIONS = 24


def fill(
    copies: Sequence[Copy],
    region: Polygon | MultiPolygon,
    placed: Sequence[Placement],
    material: Material,
) -> list[Placement]:
    """Those of the copies that find room in a region beside what is placed; the largest first.

    Copies that are alike and those of the same piece that came before found no room where one of them did not.
    """
    if region.area == 0.0:  # no such zone on this hide, or nothing but a defect
        return []
    grid = _Grid(region, material.gap)
    for placement in placed:
        grid.take(placement)
    added = []
    hopeless = set()
    order = sorted(range(len(copies)), key=lambda i: -round(copies[i].piece.area, 6))
    for copy in (copies[i] for i in order):
        kind = copy.piece.name, copy.mirrored
        if kind in hopeless:
            continue
        found = grid.room_for(copy, material)
        if found is None:
            hopeless.add(kind)
        else:
            grid.take(found)
            added.append(found)
    return added


class _Grid:
    """The cells of a region that are taken."""

    def __init__(self, region: Polygon | MultiPolygon, gap: float) -> None:
        left, bottom, right, top = region.bounds
        self.cell = max(right - left, top - bottom) / CELLS
        self.corner = np.array([left, bottom]) + 0.5 * self.cell
        self.shape = int((right - left) / self.cell) + 1, int((top - bottom) / self.cell) + 1
        self.gap = gap
        self.free_region = region
        self.taken = ~self._centres_in(region)

    def _centres_in(self, area: Polygon | MultiPolygon) -> NDArray[np.bool_]:
        x = self.corner[0] + self.cell * np.arange(self.shape[0])
        y = self.corner[1] + self.cell * np.arange(self.shape[1])
        shapely.prepare(area)
        return np.asarray(shapely.intersects_xy(area, *np.meshgrid(x, y, indexing="ij")))

    def take(self, placement: Placement) -> None:
        """Nothing more may come nearer to it than the gap."""
        body = shapely.transform(placement.piece.region, placement.place)
        around = body.buffer(self.gap + TOLERANCE) if self.gap else body
        self.free_region = self.free_region.difference(around)
        self.taken |= self._centres_in(around)

    def room_for(self, copy: Copy, material: Material) -> Placement | None:
        """The first place along the sheet, and across it."""
        rotations = fitting_rotations(copy.piece, copy.mirrored, material)
        if len(rotations) > ROTATIONS:
            rotations = rotations[np.linspace(0, len(rotations) - 1, ROTATIONS).astype(int)]
        candidates = []
        for rotation in rotations:
            body = shapely.transform(
                copy.piece.region, lambda p, angle=rotation: p @ turn(float(angle), copy.mirrored).T
            )
            candidates += [(x, y, float(rotation), body) for x, y in self._places(body)]
        candidates.sort(key=lambda entry: (round(entry[0], 6), round(entry[1], 6)))
        shapely.prepare(self.free_region)
        for x, y, rotation, body in candidates:
            if self.free_region.covers(shapely.transform(body, lambda p, at=(x, y): p + at).buffer(-0.5 * TOLERANCE)):
                return Placement(copy.piece, copy.number, copy.mirrored, rotation % 360.0, x, y)
        return None

    def _places(self, body: Polygon) -> list[tuple[float, float]]:
        """The first shifts of a body, along the sheet and across it, with which it covers no taken cell."""
        # Not at the top: it takes half a second to import, and few layouts have gaps to fill.
        from scipy.signal import fftconvolve

        low, high = np.array(body.bounds[:2]), np.array(body.bounds[2:])
        cells = np.maximum(np.ceil((high - low) / self.cell).astype(int), 1)
        if (cells > self.shape).any():
            return []
        x, y = (low[i] + self.cell * (np.arange(cells[i]) + 0.5) for i in (0, 1))
        shapely.prepare(body)
        covered = np.asarray(shapely.intersects_xy(body, *np.meshgrid(x, y, indexing="ij")))
        hits = fftconvolve(self.taken.astype(np.float32), covered[::-1, ::-1].astype(np.float32), mode="valid")
        free = np.flatnonzero(hits < 0.5)[:TRIED]
        shift = self.corner - 0.5 * self.cell - low
        return [
            (float(shift[0] + self.cell * i), float(shift[1] + self.cell * j))
            for i, j in zip(*np.unravel_index(free, hits.shape))
        ]
