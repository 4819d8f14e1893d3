"""Fair curves on a surface: through given points, bent as little as the surface allows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.polygon import arclengths
from flatnet.geometry.triangles import cross, unit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Samples of a curve, in edge lengths, and how many there are at least from point to point. Finer ones would feel
#: the facets of the surface's mesh.
SPACING = 0.5
FEWEST = 4
#: Relaxing ends where no sample moves farther than this, in spacings, or after so many steps.
STEP_TOLERANCE = 1e-3
MAX_STEPS = 60
#: How often a step that does not lower the bending is halved before the curve is taken as it is.
HALVINGS = 6


def relaxed(
    legs: Sequence[Floats], closed: bool, edge_length: float, surface: ReferenceSurface
) -> tuple[Floats, Ints]:
    """Samples of the curve of least bending through the ends of its legs, and which of them are those ends.

    Of all curves on the surface, parametrised over the legs' lengths, the one whose integral of |c''|^2 is least:
    on a plane the natural (closed: periodic) cubic spline. Samples move in their tangent planes and are taken
    back to the surface: M. Hofer, H. Pottmann, Energy-minimizing splines in manifolds, ACM TOG 23 (2004).

    Parameters
    ----------
    legs : polylines on the surface from point to point, each (k, 3) mm, to start from.
    """
    pieces, steps = [], []
    for leg in legs:
        along = arclengths(leg)
        count = max(FEWEST, int(np.ceil(along[-1] / (SPACING * edge_length))))
        at = np.linspace(0.0, along[-1], count, endpoint=False)
        pieces.append(np.stack([np.interp(at, along, column) for column in leg.T], axis=1))
        steps.append(np.full(count, along[-1] / count))
    samples = np.vstack([*pieces, *([] if closed else [legs[-1][-1:]])])
    ends = np.concatenate([[0], np.cumsum([len(piece) for piece in pieces])])
    bending = _second_differences(np.concatenate(steps), closed)
    free = np.ones(len(samples), dtype=bool)
    free[ends[:-1] if closed else ends] = False
    spacing = float(np.mean(np.concatenate(steps)))

    samples[free], normals = surface.nearest(samples[free])
    energy = _energy(bending, samples)
    for _ in range(MAX_STEPS):
        step = _tangent_step(bending, samples, free, normals)
        for halving in range(HALVINGS):
            moved = samples.copy()
            moved[free], moved_normals = surface.nearest(samples[free] + step / 2**halving)
            if _energy(bending, moved) < energy:
                break
        else:
            break
        farthest = float(np.linalg.norm(moved - samples, axis=1).max())
        samples, normals, energy = moved, moved_normals, _energy(bending, moved)
        if farthest < STEP_TOLERANCE * spacing:
            break
    return (np.vstack([samples, samples[:1]]) if closed else samples), ends


def _second_differences(steps: Floats, closed: bool) -> sp.csr_array:
    """Rows whose squares applied to samples add up to the integral of |c''|^2, (r, n); `steps` between samples."""
    before, after = (np.roll(steps, 1), steps) if closed else (steps[:-1], steps[1:])
    count = len(steps) if closed else len(steps) + 1
    middle = np.arange(count) if closed else np.arange(1, count - 1)
    both = before + after
    weight = np.sqrt(both / 2.0)
    left, right = weight * 2.0 / (before * both), weight * 2.0 / (after * both)
    rows = np.arange(len(middle))
    return sp.csr_array(
        (
            np.concatenate([left, -left - right, right]),
            (np.tile(rows, 3), np.concatenate([(middle - 1) % count, middle, (middle + 1) % count])),
        ),
        shape=(len(middle), count),
    )


def _energy(bending: sp.csr_array, samples: Floats) -> float:
    return float(np.sum((bending @ samples) ** 2))


def _tangent_step(bending: sp.csr_array, samples: Floats, free: NDArray[np.bool_], normals: Floats) -> Floats:
    """The step of the free samples, (f, 3), in their tangent planes, to the least bending there is in these."""
    # Two unit vectors of each tangent plane: one across the axis that the normal leans on least.
    axis = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = unit(cross(normals, axis))
    tangents = np.stack([first, cross(normals, first)], axis=2)  # (f, 3, 2)
    of_free = bending[:, np.flatnonzero(free)]
    #      u    v
    # x [ B Tx  B Tx ]   B: second differences of the free samples
    # y [ B Ty  B Ty ]
    # z [ B Tz  B Tz ]
    blocks = [[of_free @ sp.diags_array(tangents[:, c, k]) for k in range(2)] for c in range(3)]
    jacobian = sp.block_array(blocks, format="csr")
    residual = (bending @ samples).T.ravel()
    u, v = np.split(spsolve((jacobian.T @ jacobian).tocsc(), -jacobian.T @ residual), 2)
    return u[:, None] * tangents[:, :, 0] + v[:, None] * tangents[:, :, 1]
