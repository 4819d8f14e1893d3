"""Tessellate the region inside the planar boundary B^p into the planar mesh M^p (paper 3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flatnet.failure import PatchFailure
from flatnet.fitting.results import PlanarBoundary, PlanarMesh
from flatnet.geometry.crossings import polygon_crossings
from flatnet.geometry.delaunay import delaunay_flips, drop_degree_three, half_edge_vertices, planar_cross, twins_of
from flatnet.geometry.polygon import edge_vectors, side_lengths
from flatnet.geometry.refinement import Limits, in_lens, near_segments, refine
from flatnet.geometry.smoothing import area_smoothing, shape_smoothing
from flatnet.geometry.triangles import signed_areas, unit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

SQRT3 = float(np.sqrt(3.0))

#: Distance that sampling points keep from the boundary, in edge lengths. Above 0.5 no edge between two of
#: them can cross the boundary; 0.54 to 0.6 gave the best smallest angles on thirty outlines.
CLEARANCE = 0.57

#: Interior vertices planned for even the smallest patch, to end with about 40; and how many are enough where a
#: few long boundary edges leave no room for more without thin triangles.
PLANNED_INTERIOR, ENOUGH_INTERIOR = 46, 20

#: Lens angles to try until there are enough interior vertices, rad. 120 degrees allow 30 degrees at both ends
#: of a boundary edge; a patch of few long edges has room for more vertices only if triangles may be flatter.
LENS_ANGLES = np.radians([120.0, 135.0, 150.0])

#: The edge length of a small patch is not made smaller than this part of its mean boundary edge.
SHORTEST_EDGE = 0.15

#: Triangles with a smaller angle are refined, rad. Delaunay refinement ends below 30 degrees.
MIN_ANGLE = np.radians(27.0)

#: Triangles larger than an equilateral one of this many edge lengths are refined.
LARGEST_TRIANGLE = 1.6

#: Steps and damping of the smoothing by areas, as in the paper.
SMOOTHING_STEPS, SMOOTHING_DAMPING = 10, 0.25

#: Refinement and shape smoothing in turns: at most so many turns, each of so many times flips and steps. More
#: turns change the second digit of a few meshes.
TURNS, FLIPS_PER_TURN, STEPS_PER_FLIPS = 3, 3, 6

#: Layers of regular triangles next to the boundary region that are improved together with it.
LAYERS = 3

#: How far each side of a closed slit moves aside while the patch is tessellated, and the width up to which a
#: slit counts as closed, in mean boundary edges.
SLIT_OPENING, SLIT_WIDTH = 1e-3, 2e-3


@dataclass(frozen=True)
class Parts:
    """A triangulation in two parts: the region along the boundary, and the core of regular triangles."""

    positions: Floats
    region: Ints
    core: Ints


def tessellate(planar_boundary: PlanarBoundary, edge_length: float) -> PlanarMesh:
    """Fill B^p with nearly regular triangles, graded towards its edges.

    The four steps of the paper (sampling, regular triangulation, constrained Delaunay triangulation,
    smoothing) and what the later stages need beyond them: no interior edge joins two boundary vertices, which
    would be a crease that no solver can move, hence every corner is divided and no triangle has three
    boundary corners; thin and large triangles are refined; the smallest angles are raised by flips and
    smoothing.

    Parameters
    ----------
    planar_boundary : B^p, anticlockwise, in its canonical frame: the rows run along x, symmetric to y = 0
        and x = 0, so that the same outline gets the same mesh whichever vertex is the first.
    edge_length : target length of the interior edges, mm; shortened where a small patch would get fewer than
        about 40 interior vertices. Boundary edges stay as they are.

    Raises
    ------
    PatchFailure
        `self_intersection` where the outline crosses or touches itself, other than the sides of slits.
    """
    outline = planar_boundary.positions
    opened = open_slits(outline)
    check_simple(opened)
    length = regular_edge_length(opened, edge_length)
    for lens_angle in LENS_ANGLES:
        mesh = fill(opened, length, float(lens_angle))
        if len(mesh.positions) - len(outline) >= ENOUGH_INTERIOR:
            break
        length = max(0.9 * length, min(length, shortest_edge_length(opened)))
    positions = np.concatenate([outline, mesh.positions[len(outline) :]])
    return PlanarMesh(positions, np.concatenate([mesh.region, mesh.core]), len(outline))


def check_simple(outline: Floats) -> None:
    """Raise `self_intersection` where the outline touches or crosses itself."""
    crossings = polygon_crossings(outline)
    if crossings:
        i, _, j, _ = crossings[0]
        raise PatchFailure.of(
            "self_intersection",
            "tessellation",
            f"the flat outline crosses itself in {len(crossings)} places; boundary edges {i} and {j} meet.",
            "Cut the patch in two between these edges, or draw its boundary less winding.",
            where=f"boundary edges {i} and {j}",
        )


def open_slits(outline: Floats) -> Floats:
    """Move the two sides of closed slits apart, into the patch; the tips stay.

    A side of a slit is an edge that another edge covers in the opposite direction; its vertices move along
    the bisector of their inner angle.
    """
    n = len(outline)
    ends = np.roll(outline, -1, axis=0)
    mean_length = float(side_lengths(outline).mean())
    width = SLIT_WIDTH * mean_length
    middles = shapely.points(0.5 * (outline + ends))
    p, q = shapely.STRtree(middles).query(middles, predicate="dwithin", distance=width)
    apart = np.maximum(
        np.linalg.norm(outline[p] - ends[q], axis=1), np.linalg.norm(ends[p] - outline[q], axis=1)
    )
    p, q = p[(apart < width) & (p != q)], q[(apart < width) & (p != q)]
    if not len(p):
        return outline
    moves = np.zeros(n, dtype=bool)
    moves[p] = moves[(p + 1) % n] = True
    moves[p[q == (p - 1) % n]] = False

    along = unit(edge_vectors(outline))
    along += np.roll(along, 1, axis=0)
    inwards = unit(np.stack([-along[moves, 1], along[moves, 0]], axis=1))
    opened = outline.copy()
    opened[moves] += SLIT_OPENING * mean_length * inwards
    return opened


def regular_edge_length(outline: Floats, target: float) -> float:
    """The target, or what gives `PLANNED_INTERIOR` interior vertices where that is less.

    A mesh of equilateral triangles of edge L with n boundary edges and m interior vertices has 2 m + n - 2
    triangles of area sqrt(3) / 4 L^2. Every boundary edge has an interior vertex across and few serve more
    than two edges, so many boundary edges bring enough interior vertices at any edge length.
    """
    if len(outline) >= 2 * PLANNED_INTERIOR:
        return target
    area = 0.5 * float(np.sum(planar_cross(outline, np.roll(outline, -1, axis=0))))
    enough = np.sqrt(area / (SQRT3 / 4.0 * (2 * PLANNED_INTERIOR + len(outline) - 2)))
    return float(min(target, max(enough, shortest_edge_length(outline))))


def shortest_edge_length(outline: Floats) -> float:
    """The least edge length that a small patch may get, mm."""
    return SHORTEST_EDGE * float(side_lengths(outline).mean())


def fill(outline: Floats, length: float, lens_angle: float) -> Parts:
    """Triangulate the inside of a simple outline with edges of about the given length."""
    limits = Limits(MIN_ANGLE, LARGEST_TRIANGLE * length / SQRT3, lens_angle)
    points, regular = sample(outline, length, lens_angle)
    return improve(join(outline, points, regular), outline, limits)


def sample(outline: Floats, length: float, lens_angle: float) -> tuple[Floats, Ints]:
    """Rows of points inside the outline and the regular triangles between them (paper 3.2, steps 1 and 2)."""
    height = 0.5 * SQRT3 * length
    rows = int(np.abs(outline[:, 1]).max() / height) + 1
    columns = int(np.abs(outline[:, 0]).max() / length) + 2
    row, column = np.meshgrid(np.arange(-rows, rows + 1), np.arange(-columns, columns + 1), indexing="ij")
    odd = row % 2 == 1
    points = np.stack([length * (column + 0.5 * odd), height * row], axis=-1)
    kept = clear_of_boundary(points.reshape(-1, 2), outline, length, lens_angle).reshape(row.shape)
    number = np.where(kept, np.cumsum(kept).reshape(row.shape) - 1, -1)
    return points[kept], layout_triangles(number, odd[:, 0])


def clear_of_boundary(points: Floats, outline: Floats, length: float, lens_angle: float) -> Bools:
    """Which points lie inside the outline, clear of its edges by `CLEARANCE` and out of their lenses."""
    polygon = shapely.Polygon(outline)
    shapely.prepare(polygon)
    clear = shapely.contains_xy(polygon, points)
    inside = np.flatnonzero(clear)
    near, _ = near_segments(points[inside], outline, np.full(len(outline), CLEARANCE * length))
    clear[inside[near]] = False
    inside = np.flatnonzero(clear)
    clear[inside[in_lens(points[inside], outline, lens_angle)]] = False
    return clear


def layout_triangles(number: Ints, shifted: Bools) -> Ints:
    """The triangles between rows of numbered points.

    number : (rows, columns) int; -1 where there is no point.
    shifted : (rows,) bool; which rows lie half an edge to the right.
    """
    left, right = number[:-1, :-1], number[:-1, 1:]
    above_left, above_right = number[1:, :-1], number[1:, 1:]
    below_shifted = shifted[:-1, None]
    upright = [left, right, np.where(below_shifted, above_right, above_left)]
    hanging = [np.where(below_shifted, left, right), above_right, above_left]
    triangles = np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in (upright, hanging)])
    return triangles[(triangles >= 0).all(axis=1)]


def join(outline: Floats, points: Floats, regular: Ints) -> Parts:
    """Fill between boundary and regular triangles by constrained Delaunay triangles (paper 3.2, step 3).

    Points of no regular triangle are left out: the refinement puts vertices there if they are needed.
    """
    used, regular = np.unique(regular, return_inverse=True)
    regular = regular.reshape(-1, 3) + len(outline)
    positions = np.concatenate([outline, points[used]])
    between = constrained_delaunay(positions, outline, rims_of(regular))
    near = np.zeros(len(positions), dtype=bool)
    near[between] = True
    for _ in range(LAYERS):
        near[regular[near[regular].any(axis=1)]] = True
    core = ~near[regular].any(axis=1)
    return Parts(positions, np.concatenate([between, regular[~core]]), regular[core])


def rims_of(triangles: Ints) -> list[Ints]:
    """The rims of triangles without holes, one closed loop for each part that hangs together by edges."""
    if len(triangles) == 0:
        return []
    tails, heads, _ = half_edge_vertices(triangles)
    twins = twins_of(triangles)
    inner, rim = np.flatnonzero(twins >= 0), np.flatnonzero(twins < 0)
    size = len(triangles)
    links = coo_array((np.ones(len(inner)), (inner // 3, twins[inner] // 3)), shape=(size, size))
    part = connected_components(links, directed=False)[1][rim // 3]
    # Parts may touch at a vertex, so a vertex alone does not tell where its rim goes on.
    onwards = dict(zip(zip(part.tolist(), tails[rim].tolist()), heads[rim].tolist()))
    rims = []
    while onwards:
        (here, first), vertex = onwards.popitem()
        loop = [first]
        while vertex != first:
            loop.append(vertex)
            vertex = onwards.pop((here, vertex))
        rims.append(np.array(loop))
    return rims


def constrained_delaunay(positions: Floats, outline: Floats, holes: list[Ints]) -> Ints:
    """Triangles, anticlockwise, between outline and holes; their vertices are found by their coordinates."""
    polygon = shapely.Polygon(outline, [positions[hole] for hole in holes])
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    key = positions @ np.array([1.0, 1.0j])
    order = np.argsort(key)
    triangles = order[np.searchsorted(key[order], corners @ np.array([1.0, 1.0j]))]
    clockwise = signed_areas(positions, triangles) < 0.0
    triangles[clockwise] = triangles[clockwise][:, ::-1]
    return triangles


def improve(parts: Parts, outline: Floats, limits: Limits) -> Parts:
    """Refine and smooth (paper 3.2, step 4) in turns until no vertex is missing; the core smoothed once."""
    count = len(outline)
    positions, region, core = parts.positions, parts.region, parts.core
    region = delaunay_flips(positions, region, boundary_count=0)
    for turn in range(TURNS):
        vertices = len(positions)
        positions, region = refine(positions, region, outline, limits)
        free = np.arange(len(positions)) >= count
        if turn == 0:
            whole = np.concatenate([region, core])
            positions = area_smoothing(positions, whole, free, SMOOTHING_STEPS, SMOOTHING_DAMPING)
        elif len(positions) == vertices:
            break
        free[core] = False
        for _ in range(FLIPS_PER_TURN):
            region = drop_degree_three(positions, delaunay_flips(positions, region, count), free)
            positions = shape_smoothing(positions, region, free, STEPS_PER_FLIPS)
    return without_orphans(Parts(positions, region, core), count)


def without_orphans(parts: Parts, boundary_count: int) -> Parts:
    """Leave out vertices of no triangle; the boundary and the order of the others stay."""
    used = np.zeros(len(parts.positions), dtype=bool)
    used[:boundary_count] = used[parts.region] = used[parts.core] = True
    number = np.cumsum(used) - 1
    return Parts(parts.positions[used], number[parts.region], number[parts.core])
