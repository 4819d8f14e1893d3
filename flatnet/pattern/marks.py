"""Marks on the surface carried to the flat piece: every point by its barycentric coordinates in the fitted mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from flatnet.failure import Finding
from flatnet.fitting.results import FittedPatch
from flatnet.network.crossings import name_ends
from flatnet.network.curves import sample_curve
from flatnet.network.drawing import draw_curve
from flatnet.project.curve_specs import CurveSpec, NormalSpec
from flatnet.project.patch_specs import MarkSpec

Floats = NDArray[np.float64]

#: Points of a line lie this part of the patch's edge length apart.
SPACING = 0.125
#: Half the length of the cross at a point, and mm between the points that draw a circle.
CROSS, CHORD = 3.0, 0.5


@dataclass(frozen=True, eq=False)
class Mark:
    """A line or point that is drawn on a piece and not cut.

    Attributes
    ----------
    kind : as in the project: stitch, skive, drill, eyelet ...
    points : (k, 2) float, mm, in the piece's frame; one for a point.
    diameter : of a round hole, mm; None: none is drawn.
    """

    name: str
    kind: str
    points: Floats
    diameter: float | None = None

    def __post_init__(self) -> None:
        self.points.setflags(write=False)

    @property
    def lines(self) -> list[Floats]:
        """What is drawn, (k, 2) each: a line itself, a point as a cross and, where it has a diameter, a circle."""
        if len(self.points) > 1:
            return [self.points]
        cross = [self.points[0] + CROSS * np.array([-d, d]) for d in np.eye(2)]
        if self.diameter is None:
            return cross
        count = max(24, int(np.ceil(np.pi * self.diameter / CHORD)))
        angle = np.linspace(0.0, 2.0 * np.pi, count + 1)
        circle = self.points[0] + 0.5 * self.diameter * np.column_stack([np.cos(angle), np.sin(angle)])
        return [*cross, circle]


def carry(fitted: FittedPatch, points: Floats) -> tuple[Floats, Floats]:
    """The places on the flat piece of the mesh points that are nearest to points in space.

    Parameters
    ----------
    points : (k, 3) float, mm.

    Returns
    -------
    flat : (k, 2) float, mm.
    distance : (k,) float, mm; of the points from the mesh.
    """
    mesh = trimesh.Trimesh(fitted.mesh.vertices, fitted.mesh.triangles, process=False)
    feet, distance, triangles = trimesh.proximity.closest_point(mesh, points)
    weights = trimesh.triangles.points_to_barycentric(mesh.triangles[triangles], feet)
    corners = fitted.flat[fitted.mesh.triangles[triangles]]
    return np.einsum("kc,kcd->kd", weights, corners), distance


def make_marks(fitted: FittedPatch, specs: Sequence[MarkSpec]) -> tuple[list[Mark], list[Finding]]:
    """The marks of a piece, and a warning for each that lies farther from its patch than an edge is long."""
    marks, warnings = [], []
    for spec in specs:
        flat, distance = carry(fitted, _points(spec, SPACING * fitted.patch.edge_length))
        marks.append(Mark(spec.name, spec.kind, flat, spec.diameter))
        if distance.max() > fitted.patch.edge_length:
            warnings.append(_far(fitted, spec, float(distance.max())))
    return marks, warnings


def _points(spec: MarkSpec, spacing: float) -> Floats:
    """The point of a mark, or its line in points at most `spacing` apart; given points stay among a polyline's."""
    if len(spec.points) == 1:
        return np.array(spec.points)
    line = CurveSpec(
        name=spec.name,
        start=None,
        end=None,
        points=spec.points,
        closed=spec.closed,
        kind="spline" if spec.spline else "polyline",
        on_surface=False,
        slit=False,
        edge_length=spacing,
        normals=NormalSpec("none"),
        mark=spec.mark,
    )
    drawn, _ = name_ends({line.name: line}, (), {line.name: draw_curve(line, {}, None, np.inf)})
    return np.concatenate([part.vertices for part in sample_curve(line, drawn[line.name]).stretches])


def _far(fitted: FittedPatch, spec: MarkSpec, distance: float) -> Finding:
    return Finding(
        code="mark_off",
        stage="pattern",
        patch=fitted.patch.name,
        where=f"mark '{spec.name}'",
        amount=distance,
        unit="mm",
        message=f"mark '{spec.name}' is up to {distance:.1f} mm off the patch and was taken to its nearest points.",
        remedy="Move its points onto the patch; those of another patch belong among that one's `marks`.",
    )
