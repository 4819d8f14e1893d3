"""Move the vertices of a planar triangulation for better triangles; no triangle is ever turned over."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.triangles import signed_areas

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

SQRT3 = float(np.sqrt(3.0))

#: p of `shape_smoothing`: so high that the worst triangles decide.
SHAPE_EXPONENT = 8

#: Part of a Newton step taken in `shape_smoothing`, as the neighbours move too.
SHAPE_DAMPING = 0.6

#: A step that makes things worse is halved this often before it is given up.
HALVINGS = 6

#: Part of its area that a triangle keeps in one step of `area_smoothing`.
KEPT_AREA = 0.1


def area_smoothing(positions: Floats, triangles: Ints, free: Bools, steps: int, damping: float) -> Floats:
    """Move `free` vertices towards the area-weighted centre of the triangles around them (paper 3.2, step 4).

    Parameters
    ----------
    positions : (m, 2) float.
    triangles : (t, 3) int, anticlockwise.
    free : (m,) bool.
    damping : part of the way to the centre that is taken in a step. The vertices of a triangle that would
        lose most of its area stay where they are in that step.
    """
    free = free & (_sum_at_vertices(np.ones(len(triangles)), triangles, len(positions)) > 0)
    for _ in range(steps):
        areas = signed_areas(positions, triangles)
        around = _sum_at_vertices(areas, triangles, len(positions))[free]
        centres = positions[triangles].mean(axis=1)
        step = np.zeros_like(positions)
        for c in range(2):
            moments = _sum_at_vertices(areas * centres[:, c], triangles, len(positions))[free]
            step[free, c] = damping * (moments / around - positions[free, c])
        while (lost := signed_areas(positions + step, triangles) < KEPT_AREA * areas).any():
            step[triangles[lost]] = 0.0
        positions = positions + step
    return positions


def shape_smoothing(positions: Floats, triangles: Ints, free: Bools, steps: int) -> Floats:
    """Move `free` vertices so that the worst triangles around them become more regular.

    Lowers the sum of q^p over the triangles, q = (a^2 + b^2 + c^2) / (4 sqrt(3) area) >= 1 with equality for
    the equilateral triangle: smooth, the same at any scale, without bound as a triangle collapses. In each
    step every vertex takes a damped Newton step of its own, shortened where its triangles would become worse
    by it alone, or a triangle worse than the surroundings were by all the steps together.
    """
    triangles = triangles[free[triangles].any(axis=1)]
    for _ in range(steps):
        step = SHAPE_DAMPING * _newton_steps(positions, triangles, free)
        energy = _energy(positions[triangles])
        around = _sum_at_vertices(energy, triangles, len(positions))
        for _ in range(HALVINGS):
            worse = free & (_energy_alone(positions, step, triangles) > around)
            if not worse.any():
                break
            step[worse] *= 0.5
        limit = around[triangles].max(axis=1, initial=0.0)
        halvings = 0
        while (worse := _energy((positions + step)[triangles]) > limit).any():
            step[np.unique(triangles[worse])] *= 0.5 if halvings < HALVINGS else 0.0
            halvings += 1
        positions = positions + step
    return positions


def _sum_at_vertices(values: Floats, triangles: Ints, count: int) -> Floats:
    """Sum around every vertex of a value per triangle (t,) or per corner (t, 3); (count,)."""
    corners = np.repeat(values, 3) if values.ndim == 1 else values.ravel()
    return np.bincount(triangles.ravel(), weights=corners, minlength=count).astype(np.float64)


def _energy(corners: Floats) -> Floats:
    """q^p of triangles given by their corners (t, 3, 2), infinite where they turn clockwise; (t,)."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    squares = np.sum(u * u + v * v + (v - u) ** 2, axis=1)
    areas = 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    with np.errstate(divide="ignore", over="ignore"):
        return np.where(areas > 0.0, (squares / (4.0 * SQRT3 * np.abs(areas))) ** SHAPE_EXPONENT, np.inf)


def _energy_alone(positions: Floats, step: Floats, triangles: Ints) -> Floats:
    """Energy around every vertex after its own step, its neighbours standing still; (m,)."""
    energy = np.empty(triangles.shape)
    for k in range(3):
        corners = positions[triangles]
        corners[:, k] += step[triangles[:, k]]
        energy[:, k] = _energy(corners)
    return _sum_at_vertices(energy, triangles, len(positions))


def _newton_steps(positions: Floats, triangles: Ints, free: Bools) -> Floats:
    """Newton step of the energy around each free vertex, its neighbours standing still; (m, 2).

    With s the sum of squares, A the area and q = s / (4 sqrt(3) A): the second derivatives of q by one corner
    are (4 I - (ds dA^T + dA ds^T) / A + 2 s dA dA^T / A^2) / (4 sqrt(3) A), those of q^p follow; q is convex
    in each corner, so the step leads downhill.
    """
    corners = positions[triangles]
    following, preceding = corners[:, [1, 2, 0]], corners[:, [2, 0, 1]]
    areas = signed_areas(positions, triangles)[:, None]
    factor = 1.0 / (4.0 * SQRT3 * areas)
    q = factor * np.sum((following - corners) ** 2, axis=(1, 2))[:, None]
    d_squares = np.moveaxis(2.0 * (2.0 * corners - following - preceding), 2, 0)
    d_area = 0.5 * np.stack([(following - preceding)[..., 1], (preceding - following)[..., 0]])
    d_q = factor * d_squares - q * d_area / areas
    outer = SHAPE_EXPONENT * q ** (SHAPE_EXPONENT - 1)
    inner = (SHAPE_EXPONENT - 1) / q

    def around(values: Floats) -> Floats:
        return _sum_at_vertices(outer * values, triangles, len(positions))

    def second(c: int, d: int) -> Floats:
        mixed = (d_squares[c] * d_area[d] + d_squares[d] * d_area[c]) / areas
        dd_q = factor * (4.0 * (c == d) - mixed) + 2.0 * q * d_area[c] * d_area[d] / areas**2
        return around(dd_q + inner * d_q[c] * d_q[d])

    g_x, g_y = around(d_q[0]), around(d_q[1])
    h_xx, h_xy, h_yy = second(0, 0), second(0, 1), second(1, 1)
    determinant = h_xx * h_yy - h_xy**2
    movable = free & (determinant > 0.0)
    solved = np.stack([h_yy * g_x - h_xy * g_y, h_xx * g_y - h_xy * g_x], axis=1)
    return -np.divide(solved, determinant[:, None], out=np.zeros_like(solved), where=movable[:, None])
