"""What is decided along the outline of a piece, edge by edge, and the whole of a piece of which a patch is one half."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import PatchFailure
from flatnet.network.patch import Patch, Stretch
from flatnet.pattern.allowance import Corner
from flatnet.pattern.darts import Dart, find_darts
from flatnet.pattern.seams import Seam
from flatnet.project.model import Material
from flatnet.project.seam_specs import Ends

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A curve that bends by no more than this in the flat piece, mm, is folded along the line between its ends.
STRAIGHT = 1.0


@dataclass(frozen=True, eq=False)
class Edging:
    """An outline and what is said of its edges.

    Attributes
    ----------
    sew_line : (n, 2) float, mm, anticlockwise.
    stretches : the seams along it.
    widths : (n,) float, mm; the allowance of the edge from vertex i to vertex i + 1.
    corners : vertex -> how allowances meet there.
    darts : those that stay in the piece.
    sources : (n,) int; the vertex of the patch's boundary that each vertex is, or is the mirror image of.
    """

    sew_line: Floats
    stretches: tuple[Stretch, ...]
    widths: Floats
    corners: Mapping[int, Corner]
    darts: tuple[Dart, ...]
    sources: Ints


@dataclass(frozen=True, eq=False)
class Fold:
    """The straight line of a flat piece along which it is its own mirror image: (2,) mm each."""

    start: Floats
    end: Floats

    @property
    def line(self) -> Floats:
        return np.array([self.start, self.end])

    @property
    def along(self) -> Floats:
        """(2,) unit."""
        across: Floats = self.end - self.start
        return across / np.linalg.norm(across)

    def heights(self, points: Floats) -> Floats:
        """How far points, (..., 2), lie on its left, mm."""
        offset, along = points - self.start, self.along
        heights: Floats = along[0] * offset[..., 1] - along[1] * offset[..., 0]
        return heights

    def reflect(self, points: Floats) -> Floats:
        """The mirror image of points, (..., 2)."""
        return points - 2.0 * self.heights(points)[..., None] * np.array([-self.along[1], self.along[0]])


def edging(patch: Patch, sew_line: Floats, material: Material, seams: Mapping[str, Seam]) -> Edging:
    """The outline of a fitted patch with its allowances, corners and darts.

    What is said more specially wins: a side of a curve, the patch, the material. Where both curves of a corner say how
    their allowances end, the wider one has its way: it is the one that is folded last.
    """
    stretches = patch.boundary.stretches
    usual = material.allowance if patch.allowance is None else patch.allowance
    widths = np.full(len(sew_line), usual)
    for stretch in stretches:
        spec = seams[stretch.seam].spec
        said = spec.right if stretch.reversed else spec.left
        widths[stretch.first : stretch.first + stretch.count] = usual if said is None else said
    corners = {}
    for before, after in zip((stretches[-1], *stretches[:-1]), stretches, strict=True):
        first, second = seams[before.seam], seams[after.seam]
        if first.curve == second.curve:
            continue
        a, b = widths[after.first - 1], widths[after.first]
        second_wins = second.spec.ends != Ends() and (b > a or first.spec.ends == Ends())
        corners[after.first] = Corner(second.spec.ends, "after") if second_wins else Corner(first.spec.ends)
    darts = tuple(find_darts(patch, sew_line, seams))
    return Edging(sew_line, stretches, widths, corners, darts, np.arange(len(sew_line)))


def is_on_fold(patch: Patch, seams: Mapping[str, Seam]) -> bool:
    """Whether a patch is one half of its piece; a part that was cut off such a patch away from its fold is not."""
    return any(seams[stretch.seam].curve == patch.fold for stretch in patch.boundary.stretches)


def unfolded(half: Edging, patch: Patch, seams: Mapping[str, Seam]) -> tuple[Edging, Fold]:
    """The whole piece of a patch on the fold: its half, the fold left out, and the mirror image of that.

    The half comes first: from the fold's end anticlockwise to its start.

    Raises
    ------
    PatchFailure
        `no_fold` where the curve is not straight in the flat piece, meets the patch twice, or has a patch on its
        other side.
    """
    run = _fold_run(patch, seams)
    n = len(half.sew_line)
    end, m = (run.first + run.count) % n, n - run.count
    fold = Fold(half.sew_line[run.first], half.sew_line[end])
    _check_straight(patch, fold, half.sew_line[(run.first + np.arange(run.count + 1)) % n])
    vertices = (end + np.arange(m + 1)) % n
    edges = vertices[:-1]
    rest = half.sew_line[vertices]

    def image(dart: Dart) -> Dart:
        under, over = fold.reflect(dart.under), fold.reflect(dart.over)
        return replace(dart, edges=2 * m - 1 - dart.edges[::-1], under=under, over=over)

    darts = [replace(dart, edges=(dart.edges - end) % n) for dart in half.darts]
    kept = sorted(
        (replace(stretch, first=(stretch.first - end) % n) for stretch in half.stretches if stretch.seam in run.others),
        key=lambda stretch: stretch.first,
    )
    images = [
        replace(each, first=2 * m - each.first - each.count, reversed=not each.reversed) for each in reversed(kept)
    ]
    corners = {(v - end) % n: corner for v, corner in half.corners.items() if 0 < (v - end) % n < m}
    across = {
        2 * m - v: replace(corner, edge="after" if corner.edge == "before" else "before")
        for v, corner in corners.items()
    }
    whole = Edging(
        sew_line=np.concatenate([rest, fold.reflect(rest[1:-1])[::-1]]),
        stretches=(*kept, *images),
        widths=np.concatenate([half.widths[edges], half.widths[edges][::-1]]),
        corners=corners | across,
        darts=(*darts, *(image(dart) for dart in reversed(darts))),
        sources=np.concatenate([vertices, vertices[1:-1][::-1]]),
    )
    return whole, fold


@dataclass(frozen=True)
class _FoldRun:
    """The boundary edges along the fold, and the seams of all others."""

    first: int
    count: int
    others: frozenset[str]


def _fold_run(patch: Patch, seams: Mapping[str, Seam]) -> _FoldRun:
    stretches = patch.boundary.stretches
    on_it = [seams[stretch.seam].curve == patch.fold for stretch in stretches]
    starts = [i for i in range(len(stretches)) if on_it[i] and not on_it[i - 1]]
    if len(starts) != 1:
        what = "meets the patch in more than one run, or is all of its boundary"
        raise _no_fold(patch, what, "Name one straight curve.")
    sewn = {name for stretch, on in zip(stretches, on_it, strict=True) if on for name in seams[stretch.seam].patches}
    if sewn != {patch.name}:
        others = ", ".join(f"'{name}'" for name in sorted(sewn - {patch.name}))
        raise _no_fold(
            patch, f"has {others} on its other side", f"Make that an opening: '{patch.name}' stands for both halves."
        )
    count = sum(stretch.count for stretch, on in zip(stretches, on_it, strict=True) if on)
    others_of = frozenset(stretch.seam for stretch, on in zip(stretches, on_it, strict=True) if not on)
    return _FoldRun(stretches[starts[0]].first, count, others_of)


def _check_straight(patch: Patch, fold: Fold, run: Floats) -> None:
    bend = float(np.abs(fold.heights(run)).max())
    if bend > STRAIGHT:
        raise _no_fold(
            patch,
            f"is not straight in the flat piece: it leaves the line between its ends by {bend:.1f} mm, {STRAIGHT:g} mm "
            "is what cloth gives",
            "Take `fold` out and cut two halves (`cut: 1`, `mirrored: 1`) with a seam there, or draw the curve as the "
            "straightest way on the surface (`kind: geodesic`).",
            bend,
        )


def _no_fold(patch: Patch, what: str, remedy: str, amount: float | None = None) -> PatchFailure:
    return PatchFailure.of(
        "no_fold", "pattern", f"it can't be cut on the fold: '{patch.fold}' {what}.", remedy,
        patch=patch.name, where=f"'{patch.fold}'", amount=amount, unit="mm" if amount is not None else "",
    )  # fmt: skip
