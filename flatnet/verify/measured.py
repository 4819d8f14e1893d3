"""What is measured on written files: an amount, what it may be at the most, and of what."""

from __future__ import annotations

from dataclasses import dataclass

#: abs(angle sum - 2 pi) at an interior vertex, rad.
ANGLE_SUM = 1e-9
#: abs(flat length / length in space - 1) of an edge.
STRAIN = 1e-8
#: Of vertices that are to be the same, and of lengths that are to be equal, mm ...
PLACE = 1e-6
#: ... and of the lengths of long seams, relative: round-off of their many edges.
LENGTH = 1e-9
#: A vertex of a drawing from its place, mm: coordinates are rounded to 0.001 mm, which moves it by 0.0007.
DRAWN = 0.002
#: What two drawn cut lines may lack of their gap, mm: layouts are checked to 0.001, and both lines are rounded.
APART = 0.003
#: Entries of a matrix that turns and mirrors, from orthogonality; 1e-6 mm over 10 m.
RIGID = 1e-10
#: Of rotations, degrees; 2e-5 mm over 10 m.
ROTATION = 1e-7


@dataclass(frozen=True)
class Measured:
    """One check of one thing.

    Attributes
    ----------
    check : what is checked; the same words for all things of a kind.
    file : relative to the build's folder.
    subject : patch, seam, copy ... ; empty where it is the file.
    amount, allowed : what was measured and the most that it may be; nan is never allowed.
    unit : of both; empty for numbers of things.
    words : what is wrong where it is more than allowed; empty: the figures say it.
    """

    check: str
    file: str
    subject: str
    amount: float
    allowed: float
    unit: str = ""
    words: str = ""

    @property
    def passed(self) -> bool:
        return bool(self.amount <= self.allowed)

    @property
    def excess(self) -> float:
        """Amount over allowed, to find the worst; nan counts as infinite."""
        if not self.amount <= self.allowed:
            return float("inf") if self.allowed == 0.0 or self.amount != self.amount else self.amount / self.allowed
        return self.amount / self.allowed if self.allowed else 0.0

    def __str__(self) -> str:
        where = f"{self.file}: {self.subject}" if self.subject else self.file
        unit = f" {self.unit}" if self.unit else ""
        figures = f"{self.amount:.3g}{unit}, allowed {self.allowed:.3g}{unit}"
        return f"{where}: {self.check}: {self.words + ' (' + figures + ')' if self.words else figures}"


def damage(file: str, words: str) -> Measured:
    """A file, or a part of it, that is not what a build writes."""
    return Measured("files whole", file, "", 1.0, 0.0, words=words)
