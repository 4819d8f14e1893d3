"""What a maker should know about a patch that was made: where it wrinkles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding
from flatnet.fitting.results import FittedPatch
from flatnet.geometry.wrinkles import WRINKLED
from flatnet.report.summary import counted


def patch_warnings(fitted: FittedPatch) -> list[Finding]:
    """The warnings about the finished patch."""
    return [_wrinkled(fitted)] if fitted.mesh.wrinkles.wrinkled and not fitted.patch.wrinkles_expected else []


def _wrinkled(fitted: FittedPatch) -> Finding:
    wrinkles = fitted.mesh.wrinkles
    where = _place(fitted, fitted.mesh.vertices[wrinkles.vertex])
    degrees = float(np.degrees(wrinkles.turning))
    folds = f"{counted(wrinkles.ridges, 'ridge')} and {counted(wrinkles.valleys, 'valley')}"
    return Finding(
        code="wrinkled",
        stage="report",
        where=where,
        amount=degrees,
        unit="deg",
        message=(
            f"it wrinkles: {folds}, {wrinkles.depth:.1f} mm from top to bottom, worst {where}, where the sheet turns "
            f"to and fro by {degrees:.0f} degrees within {wrinkles.reach:.0f} mm (a warning from "
            f"{np.degrees(WRINKLED):.0f} on)."
        ),
        remedy="Cut the patch there, lower normal_weight, or say `wrinkles: expected` if it is meant to.",
    )


def _place(fitted: FittedPatch, point: NDArray[np.float64]) -> str:
    """Words for a point of the mesh: the nearest place on the boundary, and where it is in space."""
    x, y, z = point
    return f"near {fitted.patch.boundary.place_near(point)}, at ({x:.1f}, {y:.1f}, {z:.1f}) mm"
