"""The cuts of a patch that are worth a trial, most promising first, told from the halves' flat outlines alone."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import PatchFailure
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.polygon import side_lengths
from flatnet.network.boundaries import winds_once
from flatnet.network.division import Cut, halves
from flatnet.network.patch import BoundaryCurve, Patch
from flatnet.remedies.cut_curve import CutPlaces, draw_cut

Floats = NDArray[np.float64]

#: How many places along the boundary, corners first, are joined in pairs.
PLACES = 24
#: Each half keeps at least this share of the boundary.
LEAST_SHARE = 0.08
#: Misfits in the same multiple of this, rad^2, are equally good: the shorter cut goes first.
SAME_MISFIT = 0.02
#: Cuts whose ends both lie within this share of the boundary of those of a better one are the same cut.
SAME_PLACE = 0.06


@dataclass(frozen=True, eq=False)
class Candidate:
    """A cut with what its halves' outlines tell.

    Attributes
    ----------
    crossings : how often the worse of the halves' flat outlines still crosses itself; infinite where there is none.
    misfit : rad^2; sum over both outlines of (theta - alpha)^2, the paper's change of shape (Eq. 1).
    """

    cut: Cut
    crossings: float
    misfit: float

    @property
    def rank(self) -> tuple[float, ...]:
        """Less is better. A short cut across a strip goes before a long one that takes off a little more."""
        length = self.cut.length
        return self.crossings * length, self.misfit // SAME_MISFIT, length


def candidate_cuts(
    patch: Patch, surface: ReferenceSurface | None, count: int, through: tuple[Floats, float] | None = None
) -> list[Candidate]:
    """At most `count` cuts between different places of the boundary, the most promising first.

    Parameters
    ----------
    through : a place, (3,) mm, and a distance: half of the cuts are to pass it that near, where such are found.
    """
    boundary = patch.boundary
    places = CutPlaces(boundary)
    arcs = np.concatenate([[0.0], np.cumsum(side_lengths(boundary.vertices))])
    share = arcs[:-1] / arcs[-1]
    found = []
    for start, end in combinations(_ends_of_cuts(boundary, share), 2):
        between = share[end] - share[start]
        if not LEAST_SHARE <= between <= 1.0 - LEAST_SHARE:
            continue
        cut = draw_cut(places, start, end, patch.edge_length, surface)
        if cut is not None:
            found.append(_screen(boundary, cut))
    found.sort(key=lambda candidate: candidate.rank)
    if through is None:
        return _different(found, share, count)
    place, near = through
    passing = [one for one in found if np.linalg.norm(one.cut.vertices - place, axis=1).min() <= near]
    first = _different(passing, share, count // 2)
    return _different([*first, *found], share, count)


def _ends_of_cuts(boundary: BoundaryCurve, share: NDArray[np.float64]) -> list[int]:
    """Corners where two seams meet, and vertices evenly between them, in the order of the boundary."""
    starts = {stretch.first for stretch in boundary.stretches}
    even = {int(np.argmin(np.abs(share - k / PLACES))) for k in range(PLACES)}
    if len(starts) == 1:  # the curve's own start: no fraction of its length names it in a project file
        even, starts = even - starts, set()
    corners = starts - set(boundary.slit_tips)
    near = {v for v in even for c in corners if 0.0 < abs(share[v] - share[c]) < 0.5 / PLACES}
    return sorted(corners | (even - near))


def _screen(boundary: BoundaryCurve, cut: Cut) -> Candidate:
    crossings, misfit = 0.0, 0.0
    for half in halves(boundary, cut, "cut"):
        if not winds_once(half):
            return Candidate(cut, np.inf, 0.0)
        try:
            outline = fit_planar_boundary(half)
        except PatchFailure as failure:
            crossed = failure.finding.code == "self_intersection" and failure.finding.amount
            crossings = max(crossings, crossed or np.inf)
        else:
            misfit += outline.angle_error * len(outline.positions)
    return Candidate(cut, crossings, misfit)


def _different(found: list[Candidate], share: NDArray[np.float64], count: int) -> list[Candidate]:
    """The first `count` cuts that are not nearly a better one."""
    kept: list[Candidate] = []
    for candidate in found:
        ends = share[[candidate.cut.start, candidate.cut.end]]
        gaps = [np.abs(ends - share[[other.cut.start, other.cut.end]]) for other in kept]
        if all(np.minimum(gap, 1.0 - gap).max() > SAME_PLACE for gap in gaps):
            kept.append(candidate)
        if len(kept) == count:
            break
    return kept
