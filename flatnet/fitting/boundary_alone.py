"""The last resort: M without a vertex inside, which is flattenable whatever the boundary (method `boundary_alone`)."""

from __future__ import annotations

import numpy as np

from flatnet.failure import Finding, PatchFailure
from flatnet.fitting.planar_boundary import opposed_normals
from flatnet.fitting.results import FlattenableMesh, Floats, PlanarBoundary, PlanarMesh, WarpedMesh
from flatnet.geometry.boundary_triangulation import triangulate_boundary
from flatnet.geometry.polygon import polygon_angles, predicted_angles
from flatnet.geometry.triangles import angle_sums, bending, hinge_angles, hinges_of
from flatnet.network.patch import BoundaryCurve

METHOD = "boundary_alone"


def boundary_alone(boundary: BoundaryCurve) -> FlattenableMesh:
    """M: the boundary's own triangulation that bends little and leaves its normals little.

    Raises
    ------
    PatchFailure
        `degenerate_curve` where the boundary lies on a line.
    """
    triangles = triangulate_boundary(boundary.vertices, boundary.normals)
    if not len(triangles):
        raise PatchFailure.of(
            "degenerate_curve",
            "flattenable_mesh",
            "its boundary lies on a line and spans nothing.",
            "Look for a curve that runs back on another one, or a point on the wrong side.",
        )
    return FlattenableMesh(boundary.vertices.copy(), triangles, len(boundary.vertices), METHOD, {}, "converged")


def stages_before(
    mesh: FlattenableMesh, flat: Floats, boundary: BoundaryCurve
) -> tuple[PlanarBoundary, PlanarMesh, WarpedMesh]:
    """B^p, M^p and M^0 of a mesh that came from none: its own flat outline, its flat piece and itself.

    Parameters
    ----------
    flat : (n, 2) float, mm.
    """
    predicted, opposed = predicted_angles(boundary.vertices, boundary.normals)
    predicted[list(boundary.slit_tips)] = 2.0 * np.pi
    outline = PlanarBoundary(
        positions=flat.copy(),
        inner_angles=angle_sums(flat, mesh.triangles),
        predicted_angles=predicted,
        lower_bounds=np.maximum(polygon_angles(boundary.vertices), boundary.min_angles),
        warnings=tuple(opposed_normals(boundary, int(vertex)) for vertex in np.flatnonzero(opposed)),
    )
    n = mesh.boundary_count
    return outline, PlanarMesh(flat.copy(), mesh.triangles, n), WarpedMesh(mesh.vertices.copy(), mesh.triangles, n)


def made_of_it_alone(mesh: FlattenableMesh, boundary: BoundaryCurve) -> Finding:
    """The warning of its own that such a patch carries: what it bends and leaves of the normals."""
    left = np.degrees(mesh.normal_deviations(boundary.normals))
    worst = int(np.argmax(left))
    sharpest = np.degrees(np.abs(hinge_angles(mesh.vertices, hinges_of(mesh.triangles))).max(initial=0.0))
    place = boundary.place(worst + 0.5)
    return Finding(
        code="boundary_alone",
        stage="flattenable_mesh",
        message=(
            f"it is made of its boundary alone, as method '{METHOD}' asks, flat between straight creases: bending "
            f"{bending(mesh.vertices, mesh.triangles):.1f}, the sharpest crease {sharpest:.0f} degrees; it leaves its "
            f"normals by {left.mean():.0f} degrees in the mean, most at {place}, by {left[worst]:.0f}."
        ),
        remedy="A last resort: method 'fair' makes a smooth sheet, where need be of the parts of a cut patch.",
        where=place,
        amount=float(left[worst]),
        unit="deg",
    )
