"""Pieces for tests: flat outlines as fitted patches, as the fitting room would hand them on."""

import numpy as np
import shapely

from flatnet.fitting.results import FittedPatch, FlattenableMesh, PlanarBoundary, PlanarMesh, WarpedMesh
from flatnet.network.patch import BoundaryCurve, Grain, Patch, Stretch
from flatnet.pattern import Piece, make_piece
from flatnet.pattern.seams import Seam
from flatnet.project.model import Material
from flatnet.project.seam_specs import SeamSpec

#: The letter F, anticlockwise: it has no axis of symmetry, so that its mirror image is another figure.
LETTER_F = np.array(
    [[0, 0], [20, 0], [20, 40], [60, 40], [60, 60], [20, 60], [20, 80], [80, 80], [80, 100], [0, 100]], float
)
SQUARE = np.array([[0, 0], [100, 0], [100, 100], [0, 100]], float)


def fitted(
    outline,
    name="piece",
    cut=1,
    mirrored=0,
    grain=(1.0, 0.0, 0.0),
    stretches=None,
    allowance=None,
    said=True,
    slit_tips=(),
) -> FittedPatch:
    """A fitted patch in the plane z = 0 whose flat outline is `outline`, one seam per edge."""
    outline = np.array(outline, float)
    n = len(outline)
    space = np.column_stack([outline, np.zeros(n)])
    if stretches is None:
        stretches = tuple(Stretch(f"seam_{i}", i, 1, False) for i in range(n))
    boundary = BoundaryCurve(space, np.tile([0.0, 0.0, 1.0], (n, 1)), stretches, np.zeros(n), slit_tips)
    grain = None if grain is None else Grain(np.array(grain), said=said)
    patch = Patch(name, boundary, 8.0, "cloth", cut, mirrored, grain, allowance)
    triangles = _triangles(outline)
    return FittedPatch(
        patch=patch,
        planar_boundary=PlanarBoundary(outline.copy(), np.zeros(n), np.zeros(n), np.zeros(n)),
        planar=PlanarMesh(outline.copy(), triangles, n),
        warped=WarpedMesh(space.copy(), triangles, n),
        mesh=FlattenableMesh(space.copy(), triangles, n, "fair", {}, "converged", 1),
        flat=outline.copy(),
        has_grain=patch.grain is not None,
        warnings=(),
        seconds={},
    )


def _triangles(outline):
    polygon = shapely.Polygon(outline)
    if not polygon.is_valid:
        return np.array([[0, 1, 2]])
    number = {tuple(point): index for index, point in enumerate(outline)}
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    return np.array([[number[tuple(c)] for c in part.exterior.coords[:3]][::-1] for part in parts])


def cloth(**changes) -> Material:
    return Material(**{"name": "cloth", "width": 500.0, **changes})


def piece(outline, material=None, **rest) -> Piece:
    patch = fitted(outline, **rest)
    return make_piece(patch, material or cloth(), seams_of(patch))


def seams_of(patch: FittedPatch) -> dict[str, Seam]:
    """Seams of which nothing is said, one per stretch."""
    names = [stretch.seam for stretch in patch.patch.boundary.stretches]
    return {name: Seam(name, i, name, SeamSpec(), (patch.patch.name,), 1.0) for i, name in enumerate(names, 1)}


def blob(seed: int, length: float = 900.0, width: float = 320.0, n: int = 60):
    """A long, smooth, star-shaped outline with hollows, like a trouser panel."""
    random = np.random.default_rng(seed)
    angle = 2.0 * np.pi * np.arange(n) / n
    radius = 1.0 + sum(
        random.uniform(-0.2, 0.2) / k * np.cos(k * angle + random.uniform(0, 2 * np.pi)) for k in range(2, 5)
    )
    return 0.5 * np.column_stack([length * radius * np.cos(angle), width * radius * np.sin(angle)])
