"""A patch of the network, ready to be fitted: its boundary curve with normals, and what it is cut from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.polygon import side_lengths

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Stretch:
    """A run of boundary edges that follows one seam (a curve's stretch between two nodes).

    Attributes
    ----------
    seam : name of the seam (`SampledStretch.name`).
    first, count : the boundary edges first .. first + count - 1, modulo n; edge i goes from vertex i to
        i + 1.
    reversed : the boundary runs against the seam's direction (the patch lies on the seam's right).
    """

    seam: str
    first: int
    count: int
    reversed: bool


@dataclass(frozen=True, eq=False)
class BoundaryCurve:
    """B: the closed polygon that a patch interpolates, anticlockwise seen against its normals.

    Attributes
    ----------
    vertices : (n, 3) float, mm.
    normals : (n, 3) float, unit; normals[i] belongs to the edge from vertex i to vertex i + 1 and is
        orthogonal to it.
    stretches : the seams that the boundary runs along, in order; they cover its n edges once.
    min_angles : (n,) float, rad; a lower bound for the flat inner angle, 0 where the user set none.
    slit_tips : indices of vertices where the boundary turns back along the other side of a slit.
    """

    vertices: Floats
    normals: Floats
    stretches: tuple[Stretch, ...]
    min_angles: Floats
    slit_tips: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        for array in (self.vertices, self.normals, self.min_angles):
            array.setflags(write=False)

    def place(self, position: float) -> str:
        """Words for the place `position` (a vertex index, or between two of them): seam and mm along it."""
        n = len(self.vertices)
        edge = int(position) % n
        lengths = side_lengths(self.vertices)
        for stretch in self.stretches:
            offset = (edge - stretch.first) % n
            if offset < stretch.count:
                along = np.take(lengths, range(stretch.first, stretch.first + stretch.count), mode="wrap")
                mm = along[:offset].sum() + (position - int(position)) * along[offset]
                return f"'{stretch.seam}' at {along.sum() - mm if stretch.reversed else mm:.1f} mm"
        return f"boundary vertex {edge}"

    def place_near(self, point: Floats) -> str:
        """Words for the boundary vertex nearest to a point, (3,) mm."""
        return self.place(int(np.argmin(np.linalg.norm(self.vertices - point, axis=1))))


@dataclass(frozen=True, eq=False)
class Grain:
    """The direction of a patch that is laid along the material's grain.

    Attributes
    ----------
    direction : (3,) float, unit, in space; or
    chord : two boundary vertices, from the first of which to the second the grain runs on the flat piece.
    said : the project says so; else a patch on which `direction` is nowhere is laid by its extent.
    """

    direction: Floats | None = None
    chord: tuple[int, int] | None = None
    said: bool = True


@dataclass(frozen=True, eq=False)
class Patch:
    """One face of the network that is to be made.

    Attributes
    ----------
    name : as in the project file.
    boundary : B with its normals.
    edge_length : target length of the interior mesh edges, mm.
    material : name of a material of the project.
    cut, mirrored : how many plain and how many mirrored copies are cut.
    grain : what is laid along the roll; None where nothing is.
    allowance : along seams that say nothing, mm; None: as the material says.
    wrinkles_expected : it is meant to wrinkle.
    strain : what its material gives: the largest strain of an edge inside the flat piece; 0: it is exact.
    simple_outline : a flat outline B^p that crosses itself is opened until it does not.
    mirror_of : the patch that it is the mirror image of.
    fold : the curve of its boundary along which it is one half of a piece.
    """

    name: str
    boundary: BoundaryCurve
    edge_length: float
    material: str
    cut: int = 1
    mirrored: int = 0
    grain: Grain | None = None
    allowance: float | None = None
    wrinkles_expected: bool = False
    strain: float = 0.0
    simple_outline: bool = False
    mirror_of: str | None = None
    fold: str | None = None
