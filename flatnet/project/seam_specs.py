"""What a project file says of the seams along its curves: allowances, notches, darts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

from flatnet.project.problems import Mark


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
    nodes : at the nodes that the curve passes, all or those that are named, on pieces whose outline runs straight on.
    marks : how many side by side at each; None: as many as tell seams apart that are alike.
    depth : from the cut line, mm.
    """

    every: float | None = None
    at: tuple[float, ...] = ()
    at_parts: tuple[float, ...] = ()
    nodes: bool | tuple[str, ...] = False
    kind: Literal["slit", "T", "V", "castle"] = "slit"
    marks: int | None = None
    depth: float = 4.0

    def is_at(self, node: str | None) -> bool:
        """Whether there is one at a node."""
        return self.nodes if isinstance(self.nodes, bool) else node in self.nodes


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
class NickSpec:
    """Cuts into an allowance that is folded over a strongly curved sew line.

    Attributes
    ----------
    every : distance of nicks along the sew line, mm.
    radius : where the sew line is less strongly curved, there are none, mm.
    clear : how far they stay away from the sew line, mm.
    folded : `back` onto the piece (a hem), or `under`, at a right angle to it (a lasting margin).
    """

    every: float
    radius: float = 50.0
    clear: float = 3.0
    folded: Literal["back", "under"] = "back"


@dataclass(frozen=True)
class SewnTo:
    """Other curves that a curve is sewn to, end to end, and by how much it is longer than they are.

    Attributes
    ----------
    curves : (name, whether it is run backwards), in the direction of the curve that is sewn to them.
    ease_part, ease_length : what it is longer, as a part of their length and in mm; the sum counts.
    """

    curves: tuple[tuple[str, bool], ...]
    ease_part: float
    ease_length: float
    mark: Mark

    def ease(self, length: float) -> float:
        """What a curve has to be longer, mm, that is sewn to others of this length."""
        return self.ease_part * length + self.ease_length


@dataclass(frozen=True)
class SeamSpec:
    """How the pieces along a curve are cut.

    Attributes
    ----------
    left, right : allowance of the piece on that side of the curve's direction, mm; None: as its patch says.
    ends : how the allowances end at corners.
    notches : None: no notches.
    dart : None: no dart; a slit is cut open like any seam.
    nicks : None: the allowance is not nicked.
    sewn_to : None: to nothing but the other side of the same curve.
    """

    left: float | None = None
    right: float | None = None
    ends: Ends = Ends()
    notches: NotchSpec | None = None
    dart: DartSpec | None = None
    nicks: NickSpec | None = None
    sewn_to: SewnTo | None = None

    def image(self, curves: Mapping[str, str], nodes: Mapping[str, str]) -> SeamSpec:
        """The same of the curve's mirror image, whose left is on the other side.

        `curves`, `nodes` : original -> image.
        """
        dart, sewn, notches = self.dart, self.sewn_to, self.notches
        if notches is not None and not isinstance(notches.nodes, bool):
            notches = replace(notches, nodes=tuple(nodes.get(name, name) for name in notches.nodes))
        if dart is not None:
            dart = replace(dart, fold="right" if dart.fold == "left" else "left")
        if sewn is not None:
            sewn = replace(sewn, curves=tuple((curves.get(name, name), back) for name, back in sewn.curves))
        return replace(self, left=self.right, right=self.left, notches=notches, dart=dart, sewn_to=sewn)
