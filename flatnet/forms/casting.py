"""Cast points onto a surface along one direction, as the sun casts a shadow."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.delaunay import planar_cross
from flatnet.geometry.triangles import unit

Floats = NDArray[np.float64]

#: A point lies in a triangle that it misses by this, in barycentric coordinates: edges have no gaps.
SLACK = 1e-9


def first_hits(surface: ReferenceSurface, points: Floats, direction: Floats) -> Floats:
    """Where rays from points first meet a surface, (n, 3) mm; nan where they miss it.

    Parameters
    ----------
    points : (n, 3) float, mm.
    direction : (3,) float, unit.
    """
    x = unit(np.cross(np.eye(3)[np.abs(direction).argmin()], direction))
    plane = np.stack([x, np.cross(direction, x)], axis=1)  # what is seen along the direction, (3, 2)
    corners = np.asarray(surface.mesh.triangles, dtype=float)
    seen, depth = corners @ plane, corners @ direction
    aim, start = points @ plane, points @ direction
    tree = shapely.STRtree(shapely.box(*seen.min(axis=1).T, *seen.max(axis=1).T))
    ray, triangle = tree.query(shapely.points(aim), predicate="intersects")
    a, b, c = seen[triangle].transpose(1, 0, 2)
    area = planar_cross(b - a, c - a)
    upright = area == 0.0  # seen edge-on: its neighbours are met
    area = np.where(upright, 1.0, area)
    to = [corner - aim[ray] for corner in (a, b, c)]
    parts = [planar_cross(to[i - 2], to[i - 1]) for i in range(3)]
    weights = np.stack(parts, axis=1) / area[:, None]
    distance = np.einsum("ij,ij->i", weights, depth[triangle]) - start[ray]
    hit = ~upright & (weights.min(axis=1) >= -SLACK) & (distance >= 0.0)
    nearest = np.full(len(points), np.inf)
    np.minimum.at(nearest, ray[hit], distance[hit])
    landed: Floats = np.where(np.isfinite(nearest)[:, None], nearest[:, None], np.nan) * direction + points
    return landed
