"""The reference surface that curves are drawn on: a user's mesh or a form of ours, in mm, z up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ReferenceSurface:
    """A triangle mesh with smooth normals on its outer side.

    Attributes
    ----------
    mesh : in mm, z up, faces anticlockwise seen from outside.
    name : for messages.
    """

    mesh: trimesh.Trimesh
    name: str

    def nearest(self, points: Floats) -> tuple[Floats, Floats]:
        """The nearest points of the surface and its unit normals there, both (n, 3).

        Normals are interpolated between the vertex normals of the triangle, so that they turn smoothly.
        """
        raise NotImplementedError
