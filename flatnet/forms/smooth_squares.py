"""Where a surface is smooth and like a disk: squares on it to draw a first patch in."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.triangles import unit

Floats = NDArray[np.float64]

#: Sides of the squares that are tried, over the extent of the surface.
SIDES = (0.1, 0.07, 0.05, 0.03, 0.02)
#: Points of a square that are looked at, along each side.
SAMPLES = 5
#: Places spread over the surface that are looked at, besides its outermost points.
PLACES = 60
#: Of each size so many places are given, the smoothest.
OF_EACH = 4
#: Normals in a square turn by no more than this from its middle's, rad ...
LARGEST_TURN = np.radians(50.0)
#: ... and neighbouring samples stay no nearer to each other than this, over their distance when flat.
LEAST_STEP = 0.7


def smooth_squares(surface: ReferenceSurface) -> Iterator[Floats]:
    """Corners of squares on a surface, anticlockwise seen from outside, (4, 3) mm each: the largest first.

    Tried round the surface's points nearest to the middles of its bounding box's sides, round its outermost vertices
    along x, y and z, and round places spread evenly over its area. A square whose samples' normals differ much, or
    which cross to another sheet of the surface or past a rim, is left out.
    """
    low, high = surface.mesh.bounds
    middles, normals = surface.nearest(_places(surface, low, high))
    along = unit(np.cross(np.eye(3)[np.abs(normals).argmin(axis=1)], normals))
    across = np.cross(normals, along)
    grid = np.linspace(-0.5, 0.5, SAMPLES)
    u, v = (part[..., None] for part in np.meshgrid(grid, grid, indexing="ij"))  # (s, s, 1)
    last = SAMPLES - 1
    for part in SIDES:
        side = part * float((high - low).max())
        found: list[tuple[float, float, int, Floats]] = []
        for middle, normal, x, y in zip(middles, normals, along, across):
            flat = middle + side * (u * x + v * y)
            feet, around = surface.nearest(flat)
            feet = feet.reshape(flat.shape)
            steps = [np.linalg.norm(np.diff(feet, axis=axis), axis=2) for axis in (0, 1)]
            shortest = min(float(each.min()) for each in steps) * last / side
            longest = max(float(each.max()) for each in steps) * last / side
            turn = float(np.arccos(np.clip((around @ normal).min(), -1.0, 1.0)))
            if turn <= LARGEST_TURN and shortest >= LEAST_STEP and longest <= 1.0 / LEAST_STEP:
                corners = feet[[0, last, last, 0], [0, 0, last, last]]
                found.append((round(turn, 6), -round(shortest, 6), len(found), corners))
        for *_, corners in sorted(found, key=lambda each: each[:3])[:OF_EACH]:
            yield corners


def _places(surface: ReferenceSurface, low: Floats, high: Floats) -> Floats:
    """Points on or near the surface to look at, (k, 3) mm, the same each time."""
    mesh = surface.mesh
    middles = np.concatenate([np.eye(3), -np.eye(3)]) * 0.5 * (high - low) + 0.5 * (low + high)
    outermost = mesh.vertices[np.concatenate([mesh.vertices.argmax(axis=0), mesh.vertices.argmin(axis=0)])]
    areas = np.cumsum(mesh.area_faces)
    spread = np.searchsorted(areas, (np.arange(PLACES) + 0.5) / PLACES * areas[-1])
    return np.concatenate([middles, outermost, mesh.triangles_center[spread]])
