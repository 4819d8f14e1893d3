"""Copies of pieces laid on a sheet: what is placed, where, and how much of the sheet it uses."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatnet.pattern.piece import Piece
from flatnet.project.hides import Hide
from flatnet.project.model import Material

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Copy:
    """One thing to cut; the copies of a piece count from 1, the plain ones before the mirrored ones."""

    piece: Piece
    number: int
    mirrored: bool

    def __str__(self) -> str:
        return f"{self.piece.name} copy {self.number}{' (mirrored)' if self.mirrored else ''}"


def copies_of(pieces: Iterable[Piece]) -> list[Copy]:
    """Every copy that is to be cut, in the order of the pieces."""
    return [
        Copy(piece, number, number > piece.cut)
        for piece in pieces
        for number in range(1, piece.cut + piece.mirrored + 1)
    ]


def turn(rotation_deg: float, mirrored: bool) -> Floats:
    """R(rotation) M, (2, 2), where M mirrors y, which leaves the grain along x."""
    # Rounded, so that quarter turns have no 1e-16 in them; 5e-16 is nothing over any roll.
    c, s = (round(f(math.radians(rotation_deg)), 15) for f in (math.cos, math.sin))
    return np.array([[c, -s], [s, c]]) @ np.diag([1.0, -1.0 if mirrored else 1.0])


def turned_by(first: float, second: float) -> float:
    """Degrees between two rotations, 0 to 180: 359.9 and 0 are neighbours."""
    return abs((first - second + 180.0) % 360.0 - 180.0)


@dataclass(frozen=True, eq=False)
class Placement:
    """A copy on the sheet: a point p of the piece lies at R(rotation) M p + (x, y), M mirroring y or nothing.

    The sheet's x runs along the roll from its start, y across it from 0 to its width, seen from the side that
    the normals point to.
    """

    piece: Piece
    copy: int
    mirrored: bool
    rotation_deg: float
    x_mm: float
    y_mm: float

    def place(self, points: Floats) -> Floats:
        """Points of the piece's frame, (n, 2), on the sheet."""
        return points @ turn(self.rotation_deg, self.mirrored).T + (self.x_mm, self.y_mm)

    def as_dict(self) -> dict[str, str | int | float | bool]:
        """As report.json and layout.json say it."""
        return {
            "patch": self.piece.name,
            "copy": self.copy,
            "mirrored": self.mirrored,
            "rotation_deg": self.rotation_deg,
            "x_mm": self.x_mm,
            "y_mm": self.y_mm,
        }

    def __str__(self) -> str:
        return str(Copy(self.piece, self.copy, self.mirrored))


def left_over(copies: Sequence[Copy], placements: Iterable[Placement]) -> list[Copy]:
    """Those of the copies that are not among the placements."""
    placed = {(placement.piece.name, placement.copy) for placement in placements}
    return [copy for copy in copies if (copy.piece.name, copy.number) not in placed]


@dataclass(frozen=True, eq=False)
class Layout:
    """A sheet (a length of a roll, or a hide) with its pieces.

    Attributes
    ----------
    sheet : the sheets of a material count from 1.
    draft : laid plainly, in rows or one by one, because the nesting engine gave no valid layout.
    digest : of everything that the layout was made from (`stored.digest_of`).
    seconds : that the engine was given.
    """

    material: Material
    placements: tuple[Placement, ...]
    sheet: int = 1
    draft: bool = False
    digest: str = ""
    seconds: int = 0

    @property
    def hide(self) -> Hide | None:
        """What the pieces lie on, where that is no rectangle."""
        return self.material.hides[self.sheet - 1] if self.material.hides else None

    @property
    def name(self) -> str:
        """Its material, and which of several sheets or hides of it this is."""
        kind = "hide" if self.hide else "sheet"
        return f"{self.material.name} · {kind} {self.sheet}" if self.sheet > 1 else self.material.name

    @property
    def used_length(self) -> float:
        """mm of the sheet, from its start."""
        return max(float(p.place(p.piece.cut_line)[:, 0].max()) for p in self.placements)

    @property
    def size(self) -> tuple[float, float]:
        """Length and width of what is drawn, mm: the used length of a roll or sheet, all of a hide."""
        return self.hide.size if self.hide else (self.used_length, self.material.width)

    @property
    def title_size(self) -> str:
        """The same in a title, the width first."""
        length, width = self.size
        return f"{round(width, 1):g} x {length:.1f} mm"

    @property
    def area(self) -> float:
        """mm^2 of the material: width x used length; of a hide all of it, defects too."""
        return self.hide.area if self.hide else self.material.width * self.used_length

    @property
    def utilisation(self) -> float:
        """Area inside the cut lines over `area`."""
        return sum(p.piece.area for p in self.placements) / self.area
