"""Insert vertices into a planar triangulation: no chords, no ears, few thin triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.geometry.delaunay import (
    TIE_WEIGHT,
    delaunay_flips,
    flip,
    half_edge_vertices,
    insert,
    locate,
    one_per_triangle,
    planar_cross,
    tie_break,
    twins_of,
)
from flatnet.geometry.polygon import side_lengths
from flatnet.geometry.triangles import corner_angles

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

#: Rounds of refinement; each splits all that are far enough apart, so that a dozen are enough: only a bound.
MAX_ROUNDS = 60


@dataclass(frozen=True)
class Limits:
    """What `refine` mends, and where it may not put a vertex.

    Attributes
    ----------
    min_angle : rad; a triangle with a smaller angle is thin.
    max_radius : a triangle with a larger circumradius is large.
    lens_angle : rad; no vertex sees a boundary edge under a larger angle, as that would make the angles at
        the edge small.
    """

    min_angle: float
    max_radius: float
    lens_angle: float


def near_segments(points: Floats, outline: Floats, distances: Floats) -> tuple[Ints, Ints]:
    """Pairs of a point and an edge of the outline that lie within the edge's distance of each other."""
    segments = shapely.linestrings(np.stack([outline, np.roll(outline, -1, axis=0)], axis=1))
    tree = shapely.STRtree(shapely.points(points))
    edges, near = tree.query(segments, predicate="dwithin", distance=distances)
    return near, edges


def in_lens(points: Floats, outline: Floats, lens_angle: float) -> Bools:
    """Whether a point sees some edge of the outline under more than `lens_angle`, (m,)."""
    height = 0.5 / np.tan(0.5 * lens_angle)
    point, edge = near_segments(points, outline, height * side_lengths(outline))
    u = outline[edge] - points[point]
    v = np.roll(outline, -1, axis=0)[edge] - points[point]
    angle = np.arctan2(np.abs(planar_cross(u, v)), np.sum(u * v, axis=1))
    hit = np.zeros(len(points), dtype=bool)
    hit[point[angle > lens_angle]] = True
    return hit


def refine(positions: Floats, triangles: Ints, outline: Floats, limits: Limits) -> tuple[Floats, Ints]:
    """Split every chord, then cure thin and large triangles by their circumcentres.

    A circumcentre of a Delaunay triangle is no nearer to any vertex than its circumradius, so a thin triangle
    never breeds shorter edges than its own (as long as 2 sin(min_angle) < 1), and triangles grade from short
    boundary edges to long ones. The boundary itself is not touched.

    Parameters
    ----------
    positions : (m, 2) float; the first are the outline's.
    triangles : (t, 3) int, anticlockwise.
    outline : (n, 2) float.
    """
    count = len(outline)
    for _ in range(MAX_ROUNDS):
        triangles = delaunay_flips(positions, triangles, count)
        flip_chords(positions, triangles, count, limits.min_angle)
        points, place = chord_splits(positions, triangles, count)
        if len(points) == 0:
            points, place = circumcentres(positions, triangles, outline, limits)
        if len(points) == 0:
            break
        positions, triangles = insert(positions, triangles, points, place)
    return positions, triangles


def chords_of(triangles: Ints, boundary_count: int) -> tuple[Ints, Ints]:
    """Half-edges inside the mesh that join two boundary vertices, one of each pair, and their twins."""
    tails, heads, _ = half_edge_vertices(triangles)
    twin = twins_of(triangles)
    inner = twin > np.arange(len(twin))
    chords = np.flatnonzero(inner & (tails < boundary_count) & (heads < boundary_count))
    return chords, twin[chords]


def flip_chords(positions: Floats, triangles: Ints, boundary_count: int, min_angle: float) -> None:
    """Flip, in place, chords that have an inner vertex on both sides, if that makes no thin triangle."""
    chords, twins = chords_of(triangles, boundary_count)
    tails, heads, opposite = half_edge_vertices(triangles)
    tails, heads, left, right = tails[chords], heads[chords], opposite[chords], opposite[twins]
    angle = np.minimum(
        _least_angle(positions, tails, right, left), _least_angle(positions, right, heads, left)
    )
    good = (left >= boundary_count) & (right >= boundary_count) & (angle > min_angle)
    chords, twins = chords[good], twins[good]
    chosen = one_per_triangle(chords // 3, twins // 3, angle[good])
    flip(triangles, chords[chosen], twins[chosen])


def _least_angle(positions: Floats, a: Ints, b: Ints, c: Ints) -> Floats:
    """Smallest angle of the triangles (a, b, c), rad; negative where they turn clockwise."""
    corners = np.stack([a, b, c], axis=1)
    least = corner_angles(positions, corners).min(axis=1, initial=np.pi)
    return least * np.sign(planar_cross(positions[b] - positions[a], positions[c] - positions[a]))


def chord_splits(positions: Floats, triangles: Ints, boundary_count: int) -> tuple[Floats, Ints]:
    """Midpoints of chords, no two of one triangle, and a triangle that holds each.

    A lone triangle has no chord and three boundary edges: it is split at its centre.
    """
    if len(triangles) == 1:
        return positions[triangles].mean(axis=1), np.zeros(1, dtype=np.int64)
    chords, twins = chords_of(triangles, boundary_count)
    tails, heads, _ = half_edge_vertices(triangles)
    middle = 0.5 * (positions[tails[chords]] + positions[heads[chords]])
    length = np.linalg.norm(positions[heads[chords]] - positions[tails[chords]], axis=1)
    score = length / max(length.max(initial=0.0), np.finfo(float).tiny) + TIE_WEIGHT * tie_break(middle)
    chosen = one_per_triangle(chords // 3, twins // 3, score)
    return middle[chosen], chords[chosen] // 3


def circumcentres(
    positions: Floats, triangles: Ints, outline: Floats, limits: Limits
) -> tuple[Floats, Ints]:
    """Circumcentres of thin and large triangles that may become vertices, and a triangle that holds each."""
    corners = positions[triangles]
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    uu, vv, twice = np.sum(u * u, axis=1), np.sum(v * v, axis=1), 2.0 * planar_cross(u, v)
    offset = np.stack([uu * v[:, 1] - vv * u[:, 1], vv * u[:, 0] - uu * v[:, 0]], axis=1) / twice[:, None]
    radius = np.linalg.norm(offset, axis=1)
    angles = corner_angles(positions, triangles).min(axis=1)
    poor = np.flatnonzero((angles < limits.min_angle) | (radius > limits.max_radius))
    points, radius = a[poor] + offset[poor], radius[poor]
    place = locate(positions, triangles, twins_of(triangles), points, poor)
    inside = np.flatnonzero(place >= 0)
    inside = inside[~in_lens(points[inside], outline, limits.lens_angle)]
    badness = angles[poor[inside]] + TIE_WEIGHT * tie_break(points)[inside]
    order = inside[np.argsort(badness, kind="stable")]
    chosen = order[_spaced(points[order], radius[order], place[order])]
    return points[chosen], place[chosen]


def _spaced(points: Floats, radius: Floats, place: Ints) -> list[int]:
    """Greedy choice, first come first, of points no nearer to each other than their radii allow."""
    disks = shapely.STRtree(shapely.points(points))
    left, right = disks.query(shapely.points(points), predicate="dwithin", distance=radius)
    rivals: list[list[int]] = [[] for _ in points]
    for p, q in zip(left.tolist(), right.tolist()):
        rivals[p].append(q)
        rivals[q].append(p)
    blocked = np.zeros(len(points), dtype=bool)
    taken: set[int] = set()
    chosen = []
    for p, triangle in enumerate(place.tolist()):
        if not blocked[p] and triangle not in taken:
            chosen.append(p)
            taken.add(triangle)
            blocked[rivals[p]] = True
    return chosen
