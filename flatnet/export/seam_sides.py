"""One side of a seam, known by its patch's vertices, found on a piece: cut on the fold, that has every seam twice."""

from __future__ import annotations

from collections.abc import Sequence

from flatnet.pattern.piece import Piece, SeamRun


def run_on(piece: Piece, seam: str, vertices: Sequence[int]) -> tuple[SeamRun, SeamRun | None] | None:
    """The seam along a piece of the patch, and its mirror image on the other half of a piece with a fold.

    None where it is the fold itself, along which the piece goes on.

    Parameters
    ----------
    vertices : of the patch's boundary, from the seam's start to its end (`sides` in report.json).
    """
    runs = [run for run in piece.seams if run.seam.name == seam]
    if not runs:
        return None
    if piece.fold is None:
        return next(run for run in runs if run.vertices.tolist() == list(vertices)), None
    # The patch's own half comes first, the image of its last stretch follows. Both sides of a slit run apart.
    half = runs[: len(runs) // 2]
    place = next(i for i, run in enumerate(half) if _ascends(run.vertices.tolist()) == _ascends(vertices))
    return half[place], runs[-1 - place]


def _ascends(vertices: Sequence[int]) -> bool:
    """Whether a run goes round anticlockwise; from the last vertex to the first it does too."""
    step = vertices[1] - vertices[0]
    return step == 1 or step < -1
