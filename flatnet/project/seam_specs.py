"""What a project file says of the seams along its curves: allowances, notches, darts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Ends:
    """How an allowance ends at the corners of a piece.

    Attributes
    ----------
    kind : `mitre` (the parallels are drawn on until they meet), `bevel` (straight from the end of the one to that of
        the other), `mirrored` (as the cut line of the neighbouring edge, mirrored in this sew line: both lie on each
        other when the allowance is folded over), `square` (at a right angle to this sew line).
    length : how far a mitre may reach from the sew line's corner, mm; None: the usual limit.
    """

    kind: Literal["mitre", "bevel", "mirrored", "square"] = "mitre"
    length: float | None = None

    @property
    def is_folded(self) -> bool:
        """Whether the end belongs to one of the two edges."""
        return self.kind in ("mirrored", "square")


@dataclass(frozen=True)
class NotchSpec:
    """Notches of a curve, cut into the allowances of the pieces on both sides.

    Attributes
    ----------
    every : distance from the start of each stretch, again and again, mm; None: no such row.
    at, at_parts : single places along the whole curve, mm and parts of its length.
    nodes : at the nodes that the curve passes, on pieces whose outline runs straight on there.
    marks : how many side by side at each; None: as many as tell seams apart that are alike.
    depth : from the cut line, mm.
    """

    every: float | None = None
    at: tuple[float, ...] = ()
    at_parts: tuple[float, ...] = ()
    nodes: bool = False
    kind: Literal["slit", "T", "V", "castle"] = "slit"
    marks: int | None = None
    depth: float = 4.0


@dataclass(frozen=True)
class DartSpec:
    """A slit that is sewn closed with what opens between its sides folded to one side of the curve's direction.

    Attributes
    ----------
    drill : distance of the drill hole from the tip, mm.
    """

    fold: Literal["left", "right"]
    drill: float = 10.0


@dataclass(frozen=True)
class SeamSpec:
    """How the pieces along a curve are cut.

    Attributes
    ----------
    left, right : allowance of the piece on that side of the curve's direction, mm; None: as its patch says.
    ends : how the allowances end at corners.
    notches : None: no notches.
    dart : None: no dart; a slit is cut open like any seam.
    """

    left: float | None = None
    right: float | None = None
    ends: Ends = Ends()
    notches: NotchSpec | None = None
    dart: DartSpec | None = None
