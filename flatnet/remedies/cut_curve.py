"""Draw a curve across a patch, from one vertex of its boundary to another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.polygon import predicted_angles
from flatnet.geometry.triangles import dot, unit
from flatnet.network.division import Cut
from flatnet.network.patch import BoundaryCurve

Floats = NDArray[np.float64]

#: A cut leaves the boundary by at least this angle on both sides, rad: less is a sliver.
LEAST_CORNER = np.radians(20.0)
#: A chord that leaves the tangent plane at one of its ends by more than this, rad, has no direction there.
STEEPEST = np.radians(80.0)
#: Farther than this from its ends, in edges, a cut keeps at least one edge away from the boundary: nearer it
#: makes a sliver, or leaves the patch.
NEAR_ENDS = 3
#: A cut that passes over or under an edge of the boundary by less than this share of the cut's length leaves the
#: patch there; farther off it passes another layer of a patch that covers itself.
SAME_LAYER = 0.25
#: Dense samples per edge of the cut.
DENSITY = 8
#: Ends of a cut farther off the reference surface than this, in edge lengths, keep the cut off it as well.
ON_SURFACE = 0.05


class CutPlaces:
    """The vertices of a boundary as ends of cuts: their normals, and the sectors that the patch fills there."""

    def __init__(self, boundary: BoundaryCurve) -> None:
        self.boundary = boundary
        self.normals = unit(boundary.normals + np.roll(boundary.normals, 1, axis=0))
        self.angles = predicted_angles(boundary.vertices, boundary.normals)[0]

    def direction(self, start: int, end: int) -> Floats | None:
        """The chord's unit direction in the tangent plane at `start`; None where it does not lead into the patch."""
        vertices, normal = self.boundary.vertices, self.normals[start]
        chord = unit(vertices[end] - vertices[start])
        flat = chord - (chord @ normal) * normal
        if np.linalg.norm(flat) < np.cos(STEEPEST):
            return None
        along = vertices[(start + 1) % len(vertices)] - vertices[start]
        along = along - (along @ normal) * normal
        turned = np.arctan2(np.cross(along, flat) @ normal, along @ flat) % (2.0 * np.pi)
        inside = LEAST_CORNER <= turned <= self.angles[start] - LEAST_CORNER
        return unit(flat) if inside else None


def draw_cut(
    places: CutPlaces, start: int, end: int, edge_length: float, surface: ReferenceSurface | None
) -> Cut | None:
    """The cut between two vertices, tangent to the patch at both; None where the straight way leads outside."""
    leaves, arrives = places.direction(start, end), places.direction(end, start)
    if leaves is None or arrives is None:
        return None
    drawn = curve_between(
        places.boundary.vertices[[start, end]],
        np.stack([leaves, arrives]),
        places.normals[[start, end]],
        edge_length,
        surface,
    )
    if drawn is None:
        return None
    vertices, normals = drawn
    inner = vertices[NEAR_ENDS:-NEAR_ENDS]
    if len(inner) and cKDTree(places.boundary.vertices).query(inner)[0].min() < edge_length:
        return None
    return None if _leaves(places.boundary, vertices) else Cut(start, end, vertices, normals)


def curve_between(
    ends: Floats, directions: Floats, normals: Floats, edge_length: float, surface: ReferenceSurface | None
) -> tuple[Floats, Floats] | None:
    """A curve between two points with given tangents and normals there, sampled evenly.

    Off a surface it is the cubic that leaves each end in its direction, with normals turned evenly from end to end:
    with the directions of the chord in the tangent planes it sets out as a geodesic would. Where both ends lie
    on the reference surface the cubic and its normals are taken to the surface.

    Parameters
    ----------
    ends, directions, normals : (2, 3) float; the directions lead away from both ends, unit.

    Returns
    -------
    vertices (k + 1, 3) and unit edge normals (k, 3); None where the surface is left, or the normals vanish.
    """
    a, b = ends
    size = float(np.linalg.norm(b - a))
    s = np.linspace(0.0, 1.0, DENSITY * max(2, int(np.ceil(size / edge_length))) + 1)[:, None]
    dense = (1 + 2 * s) * (1 - s) ** 2 * a + s**2 * (3 - 2 * s) * b
    dense += size * (s * (1 - s) ** 2 * directions[0] + s**2 * (1 - s) * directions[1])
    if surface is not None and _off(surface, ends) > ON_SURFACE * edge_length:
        surface = None
    if surface is not None:
        dense = surface.nearest(dense)[0]
    steps = np.linalg.norm(np.diff(dense, axis=0), axis=1)
    if steps.max() > edge_length:  # the surface was left, and met again elsewhere
        return None
    along = np.concatenate([[0.0], np.cumsum(steps)])
    even = np.linspace(0.0, along[-1], max(2, int(np.ceil(along[-1] / edge_length))) + 1)
    vertices = np.stack([np.interp(even, along, column) for column in dense.T], axis=1)
    if surface is not None:
        vertices = np.array(surface.nearest(vertices)[0])
    vertices[0], vertices[-1] = a, b
    of_edges = _edge_normals(vertices, normals, surface)
    return None if of_edges is None else (vertices, of_edges)


def _edge_normals(vertices: Floats, at_ends: Floats, surface: ReferenceSurface | None) -> Floats | None:
    """Unit normals of the edges, orthogonal to them; None where they vanish."""
    middles = 0.5 * (vertices[1:] + vertices[:-1])
    if surface is not None:
        normals = surface.nearest(middles)[1]
    else:
        part = ((np.arange(len(middles)) + 0.5) / len(middles))[:, None]
        normals = (1.0 - part) * at_ends[0] + part * at_ends[1]
    edges = unit(np.diff(vertices, axis=0))
    normals = normals - dot(normals, edges)[:, None] * edges
    return unit(normals) if np.linalg.norm(normals, axis=1).min() > np.cos(STEEPEST) else None


def _leaves(boundary: BoundaryCurve, vertices: Floats) -> bool:
    """Whether a cut passes through the wall that stands on the boundary, along its normals to both sides."""
    corners = boundary.vertices
    edges = np.roll(corners, -1, axis=0) - corners
    across = np.cross(boundary.normals, edges)  # into the patch
    height = SAME_LAYER * np.linalg.norm(np.diff(vertices, axis=0), axis=1).sum()
    offset = vertices[:, None] - corners
    depth = np.einsum("kij,ij->ki", offset, across)
    before, after = depth[1:-2], depth[2:-1]  # the first and last edge of the cut touch the boundary
    crosses = (before > 0.0) != (after > 0.0)
    t = np.where(crosses, before, 0.0) / np.where(crosses, before - after, 1.0)
    at = offset[1:-2] + t[:, :, None] * (offset[2:-1] - offset[1:-2])
    along = np.einsum("kij,ij->ki", at, edges) / np.einsum("ij,ij->i", edges, edges)
    over = np.abs(np.einsum("kij,ij->ki", at, boundary.normals))
    return bool((crosses & (along >= 0.0) & (along <= 1.0) & (over < height)).any())


def _off(surface: ReferenceSurface, points: Floats) -> float:
    return float(np.linalg.norm(surface.nearest(points)[0] - points, axis=1).max())
