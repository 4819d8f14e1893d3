"""A plane and the reflection in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MirrorPlane:
    """Attributes
    ----------
    point : (3,) float, mm; any of the plane.
    normal : (3,) float, unit.
    """

    point: Floats
    normal: Floats

    def heights(self, points: Floats) -> Floats:
        """Of points (n, 3) over the plane, (n,) mm."""
        return (points - self.point) @ self.normal

    def reflect(self, points: Floats) -> Floats:
        """The images of points, (n, 3) or (3,), mm; exact where the plane is x, y or z = 0."""
        return points - 2.0 * np.multiply.outer(self.heights(points), self.normal)

    def reflect_directions(self, directions: Floats) -> Floats:
        """The images of directions, (n, 3) or (3,)."""
        return directions - 2.0 * np.multiply.outer(directions @ self.normal, self.normal)

    def foot(self, points: Floats) -> Floats:
        """The points of the plane nearest to points, (n, 3) or (3,), mm."""
        return points - np.multiply.outer(self.heights(points), self.normal)


def lies_on_one_side(points: Floats, plane: MirrorPlane) -> bool:
    """Whether points (n, 3) lie on one side of a plane, but for a thousandth of their extent."""
    heights = plane.heights(points)
    return bool(min(heights.max(), -heights.min()) <= 1e-3 * np.ptp(heights))
