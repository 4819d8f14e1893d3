"""Unfold the final mesh into the plane (Property 1), exact to the flattenability it has reached."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix

from flatnet.failure import PatchFailure
from flatnet.fitting.results import SurfaceMesh
from flatnet.geometry.derivatives import edge_length_gradients
from flatnet.geometry.triangles import (
    area_vectors,
    corner_angles,
    edge_lengths,
    edges_of,
    signed_areas,
    unit,
)
from flatnet.solvers.symmetric import factored

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Gauss-Newton steps at the most; three do where the mesh is flattenable.
MAX_STEPS = 20
#: The steps end when the largest change of an edge's strain falls below this, or below this part of the largest strain:
#: a mesh that is not quite flattenable keeps some.
SETTLED, SETTLED_PART = 1e-14, 1e-2


def unfold(mesh: SurfaceMesh) -> Floats:
    """The place of every vertex in the plane, (m, 2), mm: the longest extent along x, the area's centre at 0.

    Starts from the least-squares conformal map, which is exact for a flattenable mesh up to the square of its
    condition, and polishes by Gauss-Newton on the relative edge lengths. A least-squares placement spreads what
    is left of the defects; laying one triangle after another would add it up.

    Raises
    ------
    PatchFailure
        `folded` where a triangle of the flat mesh is turned over.
    """
    flat = _polish(_conformal(mesh), mesh)
    areas = signed_areas(flat, mesh.triangles)
    if (areas <= 0.0).any():
        raise PatchFailure.of(
            "folded",
            "unfold",
            f"{int((areas <= 0.0).sum())} triangles turn over in the plane.",
            "The mesh is not flattenable enough to be unfolded; cut the patch in two.",
            amount=float((areas <= 0.0).sum()),
        )
    return _along_extent(flat, mesh, areas)


def along_grain(flat: Floats, mesh: SurfaceMesh, direction: Floats) -> Floats | None:
    """The flat mesh turned so that the mean of `direction` (3,) over the mesh points along +x.

    None where the direction is nowhere along the mesh, as `up` is on a level one.
    """
    along = _mean_direction(flat, mesh, direction)
    return None if along is None else _turned(flat, along)


def along_chord(flat: Floats, first: int, last: int) -> Floats:
    """The flat mesh turned so that vertex `last` lies along +x from vertex `first`."""
    along = flat[last] - flat[first]
    return _turned(flat, along / np.linalg.norm(along))


def _conformal(mesh: SurfaceMesh) -> Floats:
    """Least-squares conformal map with the two farthest boundary vertices held at their distance.

    For each triangle with corners in its own plane at complex w, and the unknown corners z, the map is similar
    where sum_k (w_k+2 - w_k+1) z_k = 0; rows are scaled by one over the square root of twice the area.
    """
    vertices, triangles = mesh.vertices, mesh.triangles
    lengths = [
        np.linalg.norm(vertices[triangles[:, b]] - vertices[triangles[:, a]], axis=1) for a, b in ((0, 1), (0, 2))
    ]
    w = np.zeros((len(triangles), 3), dtype=complex)
    w[:, 1] = lengths[0]
    w[:, 2] = lengths[1] * np.exp(1j * corner_angles(vertices, triangles)[:, 0])
    twice_area = 2.0 * np.linalg.norm(area_vectors(vertices, triangles), axis=1)
    coefficients = np.stack([w[:, (k + 2) % 3] - w[:, (k + 1) % 3] for k in range(3)], axis=1)
    coefficients /= np.sqrt(twice_area)[:, None]
    rows = np.repeat(np.arange(len(triangles)), 3)
    matrix = coo_matrix(
        (coefficients.ravel(), (rows, triangles.ravel())), shape=(len(triangles), len(vertices))
    ).tocsc()
    first = 0
    rim = vertices[: mesh.boundary_count]
    second = int(np.argmax(np.linalg.norm(rim - rim[first], axis=1)))
    held = np.array([first, second])
    free = np.setdiff1d(np.arange(len(vertices)), held)
    z = np.zeros(len(vertices), dtype=complex)
    z[second] = np.linalg.norm(rim[second] - rim[first])
    left = matrix[:, free]
    z[free] = factored(left.conj().T @ left).solve(-(left.conj().T @ (matrix[:, held] @ z[held])))
    flat = np.column_stack([z.real, z.imag])
    edges = edges_of(triangles)
    return flat * (edge_lengths(vertices, edges).sum() / edge_lengths(flat, edges).sum())


def _polish(flat: Floats, mesh: SurfaceMesh) -> Floats:
    """Gauss-Newton on (flat length / length - 1) of all edges; the step of least size fixes the frame."""
    edges = edges_of(mesh.triangles)
    lengths = edge_lengths(mesh.vertices, edges)
    unknowns = (2 * edges[:, :, None] + np.arange(2)).reshape(len(edges), 4)
    rows = np.repeat(np.arange(len(edges)), 4)
    # A little of the identity holds the three rigid motions; it is far below the stiffness of the mesh.
    hold = csr_matrix(
        (np.full(2 * len(flat), 1e-10 / lengths.mean() ** 2), (np.arange(2 * len(flat)),) * 2)
    )
    for _ in range(MAX_STEPS):
        strain = edge_lengths(flat, edges) / lengths - 1.0
        data = edge_length_gradients(flat, edges).reshape(len(edges), 4) / lengths[:, None]
        jacobian = csr_matrix((data.ravel(), (rows, unknowns.ravel())), shape=(len(edges), 2 * len(flat)))
        step = factored(jacobian.T @ jacobian + hold).solve(-(jacobian.T @ strain))
        flat = flat + step.reshape(-1, 2)
        left = edge_lengths(flat, edges) / lengths - 1.0
        if np.abs(left - strain).max() < max(SETTLED, SETTLED_PART * np.abs(left).max()):
            break
    return flat


def _along_extent(flat: Floats, mesh: SurfaceMesh, areas: Floats) -> Floats:
    """Moved to the centre of its area, the principal axis along x, its longer end towards +x."""
    centres = flat[mesh.triangles].mean(axis=1)
    centre = (centres * areas[:, None]).sum(axis=0) / areas.sum()
    flat, spread = flat - centre, centres - centre
    along = np.linalg.eigh(spread.T @ (spread * areas[:, None]))[1][:, 1]
    outline = flat[: mesh.boundary_count] @ along
    return _turned(flat, along if outline.max() >= -outline.min() else -along)


def _turned(flat: Floats, along: Floats) -> Floats:
    cosine, sine = along
    return flat @ np.array([[cosine, -sine], [sine, cosine]])


def _mean_direction(flat: Floats, mesh: SurfaceMesh, direction: Floats) -> Floats | None:
    """The direction in space, projected into every triangle, carried to the plane, averaged by area; unit (2,).

    None where it is nowhere along the mesh (mean shorter than 5 % of what it could be).
    """
    corners, flat_corners = mesh.vertices[mesh.triangles], flat[mesh.triangles]
    normal = area_vectors(mesh.vertices, mesh.triangles)
    area = np.linalg.norm(normal, axis=1)
    tangent = unit(corners[:, 1] - corners[:, 0])
    across = np.cross(unit(normal), tangent)
    flat_tangent = unit(flat_corners[:, 1] - flat_corners[:, 0])
    flat_across = np.stack([-flat_tangent[:, 1], flat_tangent[:, 0]], axis=1)
    carried = (tangent @ direction)[:, None] * flat_tangent + (across @ direction)[:, None] * flat_across
    mean = (carried * area[:, None]).sum(axis=0) / area.sum()
    length = float(np.linalg.norm(mean))
    return mean / length if length > 0.05 * np.linalg.norm(direction) else None
