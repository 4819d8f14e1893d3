"""Move a network to the middle of the material: half of its thickness along the normals.

A sheet that is bent keeps the lengths of its middle, which lies half its thickness outside what it is laid on. At a
vertex every patch asks the vertex to move out by h, half its thickness, along the normal n that the sheet has there:
n . d = h. The shortest d that comes nearest to all of them is taken. So the patches on both sides keep one curve: off
creases, where all normals are alike, it moves by the mean of both; at a crease to where the middles of both meet; at a
corner of a box likewise.

A patch asks once at a vertex, along the mean of the normals of its two edges there. Asked once for each edge, three
faces in a corner, one of whose normals differ, would contradict each other: six planes have no common point, and what
is left over would lift a flat face's corner out of its plane. Three planes have one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.polygon import polyline_length
from flatnet.geometry.triangles import dot, unit
from flatnet.network.graph import Dart
from flatnet.network.mirror import mirror_network
from flatnet.network.network import SampledStretch
from flatnet.project.model import Project
from flatnet.project.problems import Problem

Floats = NDArray[np.float64]

#: Normals that meet at more than this are those of a crease, rad; at less, of one smooth sheet.
CREASE = np.radians(33.0)


def to_middle(
    project: Project,
    faces: Mapping[str, Sequence[Sequence[Dart]]],
    places: Mapping[str, Floats],
    stretches: Mapping[str, SampledStretch],
) -> tuple[dict[str, Floats], dict[str, SampledStretch], list[Problem]]:
    """The nodes and stretches in the middle of the materials; as they are where no material has a thickness.

    Parameters
    ----------
    faces : patch -> its loops.
    """
    halves = {name: 0.5 * project.materials[project.patches[name].material].thickness for name in faces}
    if not any(halves.values()):
        return dict(places), dict(stretches), []
    numbers = _numbered(places, stretches)
    count = 1 + max(int(number.max()) for number in numbers.values())
    squares, pulls = np.zeros((count, 3, 3)), np.zeros((count, 3))
    for name, loops in faces.items():
        for loop in loops:
            ends, before, after = _around(loop, stretches, numbers)
            for there in _together(before, after):
                np.add.at(squares, ends, there[:, :, None] * there[:, None, :])
                np.add.at(pulls, ends, halves[name] * there)
    moves = _shortest(squares, pulls)
    own = {name: each for name, each in stretches.items() if project.curves[each.curve].mirror_of is None}
    moved = {name: each.moved(each.vertices + moves[numbers[name]]) for name, each in own.items()}
    problems = [_too_thick(project, stretches[name], each) for name, each in moved.items()]
    nodes = {name: place.copy() for name, place in places.items()}
    for stretch in moved.values():
        for node, vertex in ((stretch.start, 0), (stretch.end, -1)):
            if node is not None:
                nodes[node] = stretch.vertices[vertex].copy()
    nodes, moved, found = mirror_network(project, nodes, moved)
    return nodes, moved, [problem for problem in problems if problem] + found


def laid_back(stretch: SampledStretch, half: float) -> Floats:
    """The inner vertices, (k - 1, 3) mm, of a curve that thickness moves onto a stretch in the middle of a sheet.

    Parameters
    ----------
    half : of the thickness, mm.
    """
    first, _ = _at_ends(stretch.left_normals, closed=False)
    return stretch.vertices[1:-1] - half * first[1:]


def _numbered(places: Mapping[str, Floats], stretches: Mapping[str, SampledStretch]) -> dict[str, NDArray[np.int64]]:
    """A number for every vertex of every stretch; those in a node share the node's."""
    nodes = {name: number for number, name in enumerate(places)}
    numbers = {}
    free = len(nodes)
    for name, stretch in stretches.items():
        number = free + np.arange(len(stretch.vertices))
        free += len(number)
        if stretch.start is None or stretch.end is None:
            number[-1] = number[0]
        else:
            number[[0, -1]] = nodes[stretch.start], nodes[stretch.end]
        numbers[name] = number
    return numbers


def _around(
    loop: Sequence[Dart], stretches: Mapping[str, SampledStretch], numbers: Mapping[str, NDArray[np.int64]]
) -> tuple[NDArray[np.int64], Floats, Floats]:
    """The vertices of a loop, (n,), and the sheet's normals there on the edge before and on the one after, (n, 3)."""
    ends, firsts, lasts = [], [], []
    for dart in loop:
        stretch, number = stretches[dart.stretch], numbers[dart.stretch]
        normals = stretch.right_normals if dart.reversed else stretch.left_normals
        first, last = _at_ends(normals, number[0] == number[-1])
        if dart.reversed:
            number, first, last = number[::-1], last[::-1], first[::-1]
        ends.append(number[:-1])
        firsts.append(first)
        lasts.append(last)
    return np.concatenate(ends), np.roll(np.concatenate(lasts), 1, axis=0), np.concatenate(firsts)


def _together(before: Floats, after: Floats) -> tuple[Floats, Floats]:
    """Normals of the same sheet at the same vertex, (n, 3) unit each: their mean, or as they are across a crease."""
    smooth = (dot(before, after) > np.cos(CREASE))[:, None]
    mean = unit(before + np.where(smooth, after, 0.0))  # the sum of opposed ones has no direction
    return np.where(smooth, mean, before), np.where(smooth, mean, after)


def _at_ends(normals: Floats, closed: bool) -> tuple[Floats, Floats]:
    """The sheet's normals at the first and at the last vertex of every edge, (k, 3) unit each.

    Between two edges it is the mean of their normals, at a curve's end it goes on turning as the edge before does.
    """
    previous = np.roll(normals, 1, axis=0)
    smooth = dot(previous, normals) > np.cos(CREASE)
    if not closed:
        smooth[0] = False
    means = unit(previous + np.where(smooth[:, None], normals, 0.0))  # the sum of opposed ones has no direction
    first = np.where(smooth[:, None], means, normals)
    last = np.where(np.roll(smooth, -1)[:, None], np.roll(means, -1, axis=0), normals)
    if not closed:
        first[0] = 2.0 * (last[0] @ normals[0]) * normals[0] - last[0]
        last[-1] = 2.0 * (first[-1] @ normals[-1]) * normals[-1] - first[-1]
    return first, last


def _shortest(squares: Floats, pulls: Floats) -> Floats:
    """The shortest d that is nearest to N d = h, from N^T N, (n, 3, 3), and N^T h, (n, 3)."""
    values, vectors = np.linalg.eigh(squares)
    along = np.einsum("nij,ni->nj", vectors, pulls)
    # Two normals at an angle have values of 1 - cos and 1 + cos of it: smaller ones are round-off, and no crease.
    kept = values > np.tan(0.5 * CREASE) ** 2 * np.maximum(values[:, -1:], 1e-12)
    part = np.where(kept, along / np.where(kept, values, 1.0), 0.0)
    return np.einsum("nij,nj->ni", vectors, part)


def _too_thick(project: Project, before: SampledStretch, after: SampledStretch) -> Problem | None:
    """A problem where an edge has turned round: the curve is hollow and its radius smaller than the way out."""
    turned = np.flatnonzero(dot(np.diff(before.vertices, axis=0), np.diff(after.vertices, axis=0)) <= 0.0)
    if not len(turned):
        return None
    at = polyline_length(before.vertices[: turned[0] + 1])
    return Problem(
        project.curves[before.curve].mark,
        f"curve '{before.curve}': at {at:.1f} mm it is hollow with a radius below half the `thickness` of the "
        "material, which has no room there; make it thinner, or the curve rounder",
    )
