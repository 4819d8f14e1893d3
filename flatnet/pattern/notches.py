"""Notches: placed on a seam once, carried to every piece along it at the same arclength from the same end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.geometry.polygon import arclengths
from flatnet.network.network import SampledStretch
from flatnet.project.seam_specs import NotchSpec

Floats = NDArray[np.float64]

#: Seams whose lengths and notches differ by less, mm, can be sewn to each other by mistake.
ALIKE = 5.0
#: Most marks side by side at one notch.
MOST_MARKS = 3
#: So many notches of a seam, from its start, may have several marks to tell it from seams that are alike.
CODED = 4
#: The last notch of a row stays this part of a step away from the seam's end.
REST = 0.25
#: Lengths of stretches sum up to that of their curve but for this part.
ROUNDING = 1e-9
#: Distance of slits side by side, width of a mark that has one, and room between such marks, mm.
MARK_PITCH, MARK_WIDTH, MARK_ROOM = 4.0, 4.0, 2.0


@dataclass(frozen=True)
class SeamNotch:
    """A notch of a seam, in the seam's own direction.

    Attributes
    ----------
    edge, fraction : where it lies on the sampled curve, so that both pieces have it at the same place.
    arclength : from the seam's start, mm.
    marks : how many stand side by side, 1 to `MOST_MARKS`.
    """

    edge: int
    fraction: float
    arclength: float
    marks: int = 1

    def met_at(self, along: Floats) -> float:
        """Its arclength on a sew line whose vertices lie at the arclengths `along`, (k,) mm."""
        return float(np.interp(self.edge + self.fraction, np.arange(len(along)), along))


@dataclass(frozen=True, eq=False)
class Notch:
    """A notch on a piece, in its frame, mm.

    Attributes
    ----------
    position : (2,) on the sew line.
    foot : (2,) on the cut line, where it begins.
    inward : (2,) unit, the way it runs.
    kind : `slit`, `T`, `V` or `castle`.
    """

    seam: str
    position: Floats
    foot: Floats
    inward: Floats
    kind: str
    depth: float
    marks: int

    def __post_init__(self) -> None:
        for array in (self.position, self.foot, self.inward):
            array.setflags(write=False)

    @property
    def width(self) -> float:
        """Of each mark, mm; 0 for a slit."""
        return 0.0 if self.kind == "slit" else MARK_WIDTH

    @property
    def feet(self) -> Floats:
        """Where its marks begin, side by side about `foot`, (marks, 2)."""
        pitch = self.width + MARK_ROOM if self.width else MARK_PITCH
        shifts = pitch * (np.arange(self.marks) - 0.5 * (self.marks - 1))
        return self.foot + shifts[:, None] * self._across

    @property
    def lines(self) -> list[Floats]:
        """What is drawn, (k, 2) each."""
        strokes = _STROKES[self.kind] * (MARK_WIDTH, self.depth)
        frame = np.array([self._across, self.inward])
        return [foot + stroke @ frame for foot in self.feet for stroke in strokes]

    @property
    def _across(self) -> Floats:
        return np.array([-self.inward[1], self.inward[0]])


#: Kind -> its strokes, across in widths and inward in depths from the cut line.
_STROKES = {
    "slit": np.array([[[0.0, 0.0], [0.0, 1.0]]]),
    "T": np.array([[[0.0, 0.0], [0.0, 1.0]], [[-0.5, 1.0], [0.5, 1.0]]]),
    "V": np.array([[[-0.5, 0.0], [0.0, 1.0], [0.5, 0.0]]]),
    "castle": np.array([[[-0.5, 0.0], [-0.5, 1.0], [0.5, 1.0], [0.5, 0.0]]]),
}


def place_notches(spec: NotchSpec, stretch: SampledStretch, start: float, total: float) -> tuple[SeamNotch, ...]:
    """The notches of one stretch, in its direction.

    Parameters
    ----------
    start, total : arclength of the stretch's start along its curve, and length of the curve, mm.
    """
    along = arclengths(stretch.vertices)
    length = float(along[-1])
    is_last = total - start - length < ROUNDING * total  # it has what is said at its end
    end = np.inf if is_last else start + length
    said = [*spec.at, *(part * total for part in spec.at_parts)]
    places = {min(place - start, length) for place in said if start <= place < end}
    if spec.every is not None:
        places.update(np.arange(spec.every, length - REST * spec.every, spec.every).tolist())
    found = []
    for place in sorted(places):
        edge = min(int(np.searchsorted(along, place, side="right")) - 1, len(along) - 2)
        fraction = (place - along[edge]) / (along[edge + 1] - along[edge])
        found.append(SeamNotch(edge, float(fraction), place, spec.marks or 1))
    return tuple(found)


@dataclass(frozen=True)
class NotchedSeam:
    """What tells a seam from others when it is sewn: its length and its notches; `fixed` marks stay as they are."""

    length: float
    notches: tuple[SeamNotch, ...]
    fixed: bool

    def looks_like(self, other: NotchedSeam) -> bool:
        """Whether this seam's notches meet those of the other one."""
        if len(self.notches) != len(other.notches) or abs(self.length - other.length) >= ALIKE:
            return False
        pairs = zip(self.notches, other.notches, strict=True)
        return all(a.marks == b.marks and abs(a.arclength - b.arclength) < ALIKE for a, b in pairs)

    @property
    def backwards(self) -> NotchedSeam:
        """The same seam from its other end."""
        notches = (replace(notch, arclength=self.length - notch.arclength) for notch in reversed(self.notches))
        return replace(self, notches=tuple(notches))


def tell_apart(seams: Sequence[NotchedSeam]) -> list[NotchedSeam]:
    """Double and triple some notches, so that no two seams that are alike, and no two ends of one, can be confused.

    Each seam in turn takes the fewest marks with which it looks like none before it, from either end, nor like itself
    turned round. Where there are more seams than marks can tell apart, it takes those that fewest others have.
    """
    done: list[NotchedSeam] = []
    for seam in seams:
        coded = 0 if seam.fixed else min(len(seam.notches), CODED)
        codes = sorted(product(range(1, MOST_MARKS + 1), repeat=coded), key=lambda code: (sum(code), code[::-1]))
        best, fewest = seam, None
        for code in codes if seam.notches else []:
            marked = [replace(notch, marks=marks) for notch, marks in zip(seam.notches, code)]
            tried = replace(seam, notches=(*marked, *seam.notches[coded:]))
            others = [tried, *done]
            confused = sum(tried.backwards.looks_like(other) for other in others)
            confused += sum(tried.looks_like(other) for other in done)
            if fewest is None or confused < fewest:
                best, fewest = tried, confused
            if confused == 0:
                break
        done.append(best)
    return done


def notch_on_piece(
    seam: str, spec: NotchSpec, edge: Floats, fraction: float, marks: int, width: float, cut_line: shapely.Geometry
) -> Notch:
    """A notch on one piece.

    Parameters
    ----------
    edge : (2, 2) mm, of the sew line, anticlockwise; `fraction` of the way along it.
    width : the edge's allowance, mm.
    cut_line : all rings of it.
    """
    direction = edge[1] - edge[0]
    outward = np.array([direction[1], -direction[0]]) / np.linalg.norm(direction)
    position = edge[0] + fraction * direction
    foot = position + width * outward
    if cut_line.distance(shapely.Point(foot)) > 1e-6:  # the allowance is cut short here, or has no room
        foot = way_out(position, outward, cut_line)
    return Notch(seam, position, foot, -outward, spec.kind, spec.depth, marks)


def way_out(position: Floats, outward: Floats, cut_line: shapely.Geometry) -> Floats:
    """Where a ray from the sew line meets the cut line first; where it does not, `position`."""
    far = position + outward * np.ptp(np.reshape(cut_line.bounds, (2, 2)), axis=0).sum()
    met = shapely.get_coordinates(cut_line.intersection(shapely.LineString([position, far])))
    return met[np.argmin(np.linalg.norm(met - position, axis=1))] if len(met) else position
