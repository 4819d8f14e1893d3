"""Fold the flat piece again, by the stored dihedral angles, and compare it with the network."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order

from flatnet.verify.build import WrittenPatch
from flatnet.verify.measured import STRAIN, Measured
from flatnet.verify.mesh import WrittenMesh, aligned, corner_angles, farthest, lengths, side_lengths
from flatnet.verify.written import DamagedError, Record, WrittenFiles

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FORMAT = "flatnet-folds/1"
ENDING = ".folds.json"
#: Of stored dihedral angles from those of the mesh, rad: round-off of coordinates over the height of a triangle.
DIHEDRAL = 1e-9


@dataclass(frozen=True, eq=False)
class Folded:
    """A flat mesh folded along its edges.

    Attributes
    ----------
    vertices : (m, 3) float, mm: the mean of where a vertex's triangles have it.
    gap : mm; at the edges that were not folded on the way, how far the corners of one triangle are from where folding
        the other one's motion about the edge would have them, at the most.
    depth : how many edges a triangle is away from the first one at the most.
    """

    vertices: Floats
    gap: float
    depth: int


def read_folds(files: WrittenFiles, patch: WrittenPatch) -> Floats:
    """The stored angle of every hinge of a patch's mesh, (h,), rad."""
    record = Record(patch.beside(ENDING), files.json(patch.beside(ENDING)))
    if record.text("format") != FORMAT:
        raise DamagedError(record.file, f"its format is not {FORMAT}")
    edges, angles = record.indices("edges", 2), record.numbers("angles")
    wanted = patch.mesh.half_edges[patch.mesh.hinges]
    if len(angles) != len(edges) or not np.array_equal(edges, wanted):
        raise DamagedError(
            record.file, f"{len(angles)} angles of {len(edges)} edges, and not one for each of the {len(wanted)} "
            f"interior edges of {patch.file}",
        )
    return angles


def fold(mesh: WrittenMesh, angles: Floats) -> Folded:
    """Lay one triangle after the other into space, each by a rigid motion about the edge to the one before.

    A triangle's motion is p -> turn (p, 0) + shift. Across an edge the turn goes on by the dihedral angle about the
    edge, and the shift leaves the edge where it is. The tree of neighbours is breadth first from the middle, so that
    round-off adds up over as few triangles as possible.
    """
    flat = np.column_stack([mesh.flat, np.zeros(len(mesh.flat))])
    angle_of = dict(zip(mesh.hinges.tolist(), angles.tolist()))
    angle_of |= dict(zip(mesh.twins[mesh.hinges].tolist(), angles.tolist()))
    inside = np.flatnonzero(mesh.twins >= 0)
    count = len(mesh.triangles)
    via = {(edge // 3, mesh.twins[edge] // 3): edge for edge in inside.tolist()}
    graph = coo_matrix((np.ones(len(inside)), (inside // 3, mesh.twins[inside] // 3)), shape=(count, count)).tocsr()
    centres = mesh.flat[mesh.triangles].mean(axis=1)
    root = int(np.argmin(np.linalg.norm(centres - centres.mean(axis=0), axis=1)))
    order, before = breadth_first_order(graph, root)
    turns, shifts = np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3))
    level = np.zeros(count, dtype=np.int64)

    def folded(edge: int) -> tuple[Floats, Floats]:
        """The motion of the triangle across a half-edge, from that of the triangle that it belongs to."""
        tail, head = flat[mesh.half_edges[edge]]
        turn, shift = turns[edge // 3], shifts[edge // 3]
        turned = _rotation(turn @ (head - tail) / np.linalg.norm(head - tail), angle_of[edge]) @ turn
        middle = 0.5 * (tail + head)
        return turned, (turn - turned) @ middle + shift

    on_the_way = set()
    for triangle in order[1:]:
        edge = via[before[triangle], triangle]
        turns[triangle], shifts[triangle] = folded(edge)
        level[triangle] = level[before[triangle]] + 1
        on_the_way |= {edge, int(mesh.twins[edge])}
    corners = np.einsum("tij,tkj->tki", turns, flat[mesh.triangles]) + shifts[:, None]
    sums = np.zeros((len(flat), 3))
    np.add.at(sums, mesh.triangles, corners)
    vertices = sums / np.bincount(mesh.triangles.ravel(), minlength=len(flat))[:, None]
    gap = 0.0
    for edge in sorted(set(mesh.hinges.tolist()) - on_the_way):
        across = mesh.twins[edge] // 3
        turn, shift = folded(edge)
        gap = max(gap, farthest(flat[mesh.triangles[across]] @ turn.T + shift, corners[across]))
    return Folded(vertices, gap, int(level.max()))


def check_folds(patch: WrittenPatch, angles: Floats) -> Measured:
    """The stored angles are those of the mesh."""
    off = float(np.abs(angles - patch.mesh.dihedral_angles).max(initial=0.0))
    return Measured("stored dihedral angles", patch.beside(ENDING), patch.name, off, DIHEDRAL, "rad", "of the mesh")


def check_round_trip(patch: WrittenPatch, angles: Floats, on_curves: dict[int, Floats]) -> Iterator[Measured]:
    """The folded piece against the network along the boundary, and that it closes.

    Parameters
    ----------
    on_curves : boundary vertex -> its place on the curves of the network, (3,) mm.
    """
    mesh = patch.mesh
    folded = fold(mesh, angles)
    allowed = tolerance(mesh, folded.depth)
    file = patch.beside(ENDING)
    yield Measured("folded piece closes", file, patch.name, folded.gap, allowed, "mm")
    known = np.array(sorted(on_curves), dtype=np.int64)
    curves = np.array([on_curves[vertex] for vertex in known.tolist()]).reshape(-1, 3)
    linear, shift = aligned(folded.vertices[known], curves)
    placed = folded.vertices @ linear.T + shift
    yield Measured("folded piece on the network", file, patch.name, farthest(placed[known], curves), allowed, "mm")
    yield Measured("folded piece on the mesh", file, patch.name, farthest(placed, mesh.vertices), allowed, "mm")


def tolerance(mesh: WrittenMesh, depth: int) -> float:
    """What strained edges can move a vertex by when triangles are folded one after the other, mm.

    Edges that are off by the strain e change an angle between sides a and b, opposite c, by at most
    e (a + b + c) 2 R / (a b) <= (3 sqrt 3 / 2) e / sin^2 of the smallest angle. So the k-th triangle of a chain is
    turned by k times that, and with edges of length l its vertices are off by the sum over the chain, half of
    l depth^2 times it. Twice that, because what closes came two ways. e is the measured strain, as far as it is
    allowed, but not below the round-off of the coordinates.
    """
    edges = lengths(mesh.vertices, mesh.edges)
    rounding = 4.0 * np.finfo(float).eps * max(np.abs(mesh.vertices).max(), np.abs(mesh.flat).max()) / edges.min()
    strain = max(min(float(mesh.strain.max()), STRAIN), float(rounding))
    smallest = corner_angles(side_lengths(mesh.flat, mesh.triangles)).min()
    turned = 1.5 * np.sqrt(3.0) * strain / np.sin(smallest) ** 2
    return float(turned * edges.max() * max(depth, 1) ** 2)


def _rotation(axis: Floats, angle: float) -> Floats:
    """About a unit axis (Rodrigues), (3, 3)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
