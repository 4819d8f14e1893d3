"""Divide a sheet into pages that a printer takes: overlapping tiles, those without a piece left out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Paper:
    """Sizes in mm; `margin` all round is what printers leave white, `overlap` what two neighbours both show."""

    name: str
    width: float
    height: float
    margin: float = 10.0
    overlap: float = 10.0

    def turned(self) -> Paper:
        """The same paper the other way round."""
        return Paper(self.name, self.height, self.width, self.margin, self.overlap)

    @property
    def window(self) -> Floats:
        """What is printed on, (2,)."""
        return np.array([self.width, self.height]) - 2.0 * self.margin

    @property
    def step(self) -> Floats:
        """From tile to tile, (2,)."""
        return self.window - self.overlap


@dataclass(frozen=True, eq=False)
class Tile:
    """One page of a sheet.

    Attributes
    ----------
    column, row : from 0, along the sheet's x, and from its top down.
    corner : (2,) the lower left corner of its window on the sheet, mm.
    neighbours : which of its left, right, lower and upper neighbours are printed.
    """

    column: int
    row: int
    corner: Floats
    neighbours: tuple[bool, bool, bool, bool]

    @property
    def name(self) -> str:
        """Column as a letter, row as a number: A1 is at the top left."""
        letters, number = "", self.column
        while number >= 0:
            letters, number = chr(ord("A") + number % 26) + letters, number // 26 - 1
        return f"{letters}{self.row + 1}"


@dataclass(frozen=True, eq=False)
class Tiling:
    """The pages of a sheet that are printed, of `columns` x `rows`."""

    paper: Paper
    columns: int
    rows: int
    tiles: tuple[Tile, ...]


def tile_sheet(size: Floats, pieces: Sequence[shapely.Geometry], paper: Paper) -> Tiling:
    """The tiling of a sheet, upright or across, with fewer pages.

    Parameters
    ----------
    size : (2,) of the sheet, mm.
    pieces : all that is printed, where it lies on the sheet.
    """
    return min((_tile(size, pieces, each) for each in (paper, paper.turned())), key=lambda tiling: len(tiling.tiles))


def _tile(size: Floats, pieces: Sequence[shapely.Geometry], paper: Paper) -> Tiling:
    columns, rows = (max(1, math.ceil((length - paper.overlap) / step)) for length, step in zip(size, paper.step))
    top = size[1]
    tree = shapely.STRtree(pieces)
    printed = {}
    for row in range(rows):
        for column in range(columns):
            corner = np.array([column * paper.step[0], top - (row + 1) * paper.step[1] - paper.overlap])
            window = shapely.box(*corner, *(corner + paper.window))
            if len(tree.query(window, predicate="intersects")):
                printed[column, row] = corner
    tiles = []
    for (column, row), corner in printed.items():
        around = ((column - 1, row), (column + 1, row), (column, row + 1), (column, row - 1))
        left, right, lower, upper = (place in printed for place in around)
        tiles.append(Tile(column, row, corner, (left, right, lower, upper)))
    return Tiling(paper, columns, rows, tuple(tiles))
