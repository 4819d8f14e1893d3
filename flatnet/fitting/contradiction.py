"""Tell normals that contradict flattenability from a method that did not find the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatnet.failure import Finding
from flatnet.fitting.results import FlattenableMesh, PlanarBoundary
from flatnet.geometry.asked_curvature import asked_curvature, least_normal_deviation
from flatnet.network.patch import BoundaryCurve

#: Normals that some flat piece leaves by less than this contradict nothing that is seen, rad: two patches that leave
#: a common normal to either side make a ridge of twice as much along their seam, and 30 degrees read as an edge.
CONTRADICTION = np.radians(15.0)


@dataclass(frozen=True)
class Asked:
    """What the normals of a patch ask for.

    Attributes
    ----------
    curvature : rad; of a dome where positive, of a saddle where negative; without what the slits of the patch take.
    least_deviation : by how much some normals must give way at least, rad.
    """

    curvature: float
    least_deviation: float

    @classmethod
    def by(cls, planar_boundary: PlanarBoundary, boundary: BoundaryCurve) -> Asked:
        predicted = planar_boundary.predicted_angles.copy()
        tips = list(boundary.slit_tips)
        if tips:  # a slit opens in the flat piece by what a dome has too much
            predicted[tips] -= max(planar_boundary.asked_curvature, 0.0) / len(tips)
        return cls(asked_curvature(predicted), least_normal_deviation(boundary.vertices, predicted))

    @property
    def contradicts(self) -> bool:
        return self.least_deviation > CONTRADICTION

    @property
    def statement(self) -> str:
        """What they ask for, and what that means, as sentences that go on after a failure."""
        shape = "a dome" if self.curvature > 0.0 else "a saddle"
        if self.contradicts:
            return (
                f"Its normals ask for {self.curvature:+.2f} rad of curvature, as {shape} has, and no flat piece has "
                f"any: some must give way by about {np.degrees(self.least_deviation):.0f} degrees at least."
            )
        return (
            f"Its normals hardly contradict a flat piece: they ask for {self.curvature:+.2f} rad of curvature in all, "
            f"which a change by {np.degrees(self.least_deviation):.0f} degrees takes away."
        )

    def remedy(self, where: str) -> str:
        """What takes the curvature that is asked for."""
        degrees = abs(np.degrees(self.curvature))
        if self.curvature > 0.0:
            return f"A seam through the patch {where}, or darts of {degrees:.0f} degrees together, takes the dome."
        return f"A seam through the patch {where}, or gussets of {degrees:.0f} degrees together, takes the saddle."


def gave_way(asked: Asked, mesh: FlattenableMesh, normal_weight: float) -> tuple[Finding, ...]:
    """The warning `normals_gave_way`, where the mesh was made with a lighter weight than was asked for."""
    reached = mesh.parameters.get("normal_weight", normal_weight)
    if reached >= normal_weight:
        return ()
    return (
        Finding(
            code="normals_gave_way",
            stage="flattenable_mesh",
            message=(
                f"no mesh was found with normal_weight {normal_weight:g}, this one is made with {reached:g}. "
                f"{asked.statement}"
            ),
            remedy=asked.remedy("there") if asked.contradicts else "Try a smaller edge_length.",
            amount=reached,
        ),
    )


def contradiction(asked: Asked, mesh: FlattenableMesh, boundary: BoundaryCurve) -> tuple[Finding, ...]:
    """The warning `normals_contradict`, where they do."""
    if not asked.contradicts:
        return ()
    left = np.degrees(mesh.normal_deviations(boundary.normals))
    worst = int(np.argmax(left))
    place = boundary.place(worst + 0.5)
    return (
        Finding(
            code="normals_contradict",
            stage="flattenable_mesh",
            message=(
                f"{asked.statement[0].lower()}{asked.statement[1:]} The mesh leaves them by {left.mean():.0f} degrees "
                f"in the mean, most at {place}, by {left[worst]:.0f}."
            ),
            remedy=asked.remedy("from there"),
            where=place,
            amount=asked.curvature,
            unit="rad",
        ),
    )
