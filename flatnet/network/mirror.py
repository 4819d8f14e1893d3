"""Mirror images in the network: nodes, stretches and cuts reflected, and what both sides share put into the plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import spoken
from flatnet.geometry.mirror import MirrorPlane
from flatnet.geometry.triangles import cross, dot, unit
from flatnet.network.division import Cut
from flatnet.network.network import SampledStretch
from flatnet.network.patch import BoundaryCurve
from flatnet.project.curve_specs import CurveSpec
from flatnet.project.model import Project
from flatnet.project.problems import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: What both sides share is moved into the plane from so many edge lengths away; what is farther off is a problem.
SNAP = 0.05
#: Normals along a curve in the plane lean out of it by 60 degrees at the most, unless it is a crease.
LEAST_IN_PLANE = 0.5


def mirror_network(
    project: Project, places: Mapping[str, Floats], stretches: Mapping[str, SampledStretch]
) -> tuple[dict[str, Floats], dict[str, SampledStretch], list[Problem]]:
    """All nodes and stretches in the order of the file: originals, what both sides share in the plane, and images.

    Both sides share the nodes without an image on curves that have one, and the curves without an image around
    patches that have one.

    Parameters
    ----------
    places, stretches : of the originals.
    """
    plane = project.mirror
    if plane is None:
        return dict(places), dict(stretches), []
    shared = _shared_curves(project)
    across = {node.mirror_of: name for name, node in project.nodes.items() if node.mirror_of}
    images = [curve for curve in project.curves.values() if curve.mirror_of]
    placed, problems = _share_nodes(project, plane, places, stretches, across)
    made = {name: _ending_in(stretch, placed) for name, stretch in stretches.items()}
    for name, stretch in made.items():
        if stretch.curve in shared:
            problem = _off_plane(shared[stretch.curve], stretch, plane)
            if problem is None:
                made[name] = _in_plane(stretch, plane, _on_its_left(project, stretch.curve))
            else:
                problems.append(problem)
    placed |= {image: plane.reflect(placed[node]) for node, image in across.items() if node in placed}
    for position in placed.values():
        position.setflags(write=False)
    if not problems:
        originals = list(made.values())
        for curve in images:
            reflected = [_image(s, plane, curve.name, across, placed) for s in originals if s.curve == curve.mirror_of]
            made |= {stretch.name: stretch for stretch in reflected}
    ordered = {s.name: s for name in project.curves for s in made.values() if s.curve == name}
    return placed, ordered, problems


def _share_nodes(
    project: Project,
    plane: MirrorPlane,
    places: Mapping[str, Floats],
    stretches: Mapping[str, SampledStretch],
    across: Mapping[str, str],
) -> tuple[dict[str, Floats], list[Problem]]:
    """The nodes without an image of curves that have one, moved into the plane; those that are too far off."""
    placed = dict(places)
    problems = []
    shared = _shared_curves(project)
    image_of = {curve.mirror_of: curve for curve in project.curves.values() if curve.mirror_of}
    for stretch in stretches.values():
        curve = image_of.get(stretch.curve) or shared.get(stretch.curve)
        for node in {stretch.start: None, stretch.end: None} if curve else ():
            if curve is None or node is None or node in across:
                continue
            height = abs(float(plane.heights(places[node])))
            if height <= SNAP * curve.edge_length:
                placed[node] = plane.foot(places[node])
            elif curve.mirror_of:
                message = (
                    f"curve '{curve.name}', the mirror image of '{curve.mirror_of}', needs the image of node '{node}', "
                    f"which is {height:.2f} mm off the mirror plane; add a node: {node}_2: {{mirror_of: {node}}}"
                )
                problems.append(Problem(curve.mark, message))
    return placed, list(dict.fromkeys(problems))


def _ending_in(stretch: SampledStretch, places: Mapping[str, Floats]) -> SampledStretch:
    """A stretch that ends in its nodes where they are now; normals stay orthogonal to its first and last edge."""
    ends = [
        (index, places[node])
        for index, node in ((0, stretch.start), (-1, stretch.end))
        if node is not None and not np.array_equal(stretch.vertices[index], places[node])
    ]
    if not ends:
        return stretch
    vertices = stretch.vertices.copy()
    for index, place in ends:
        vertices[index] = place
    return stretch.moved(vertices)


def _shared_curves(project: Project) -> dict[str, CurveSpec]:
    """The curves between a patch and its mirror image: those around an original that have no image."""
    across = {curve.mirror_of for curve in project.curves.values()}
    originals = [project.patches[patch.mirror_of] for patch in project.patches.values() if patch.mirror_of]
    names = [entry.curve for patch in originals for loop in patch.loops for entry in loop]
    curves = [project.curves[name] for name in dict.fromkeys(names)]
    return {curve.name: curve for curve in curves if curve.name not in across and curve.mirror_of is None}


def _off_plane(curve: CurveSpec, stretch: SampledStretch, plane: MirrorPlane) -> Problem | None:
    heights = np.abs(plane.heights(stretch.vertices))
    worst = int(np.argmax(heights))
    if heights[worst] > SNAP * curve.edge_length:
        return Problem(
            curve.mark,
            f"curve '{curve.name}' bounds a patch that is mirrored and has no image, so that both share it; but it is "
            f"{heights[worst]:.2f} mm off the mirror plane at {spoken(stretch.vertices[worst])} mm. Draw it in the "
            f"plane, or add a curve: {curve.name}_2: {{mirror_of: {curve.name}}}",
        )
    leaning = 1.0 - np.abs(stretch.left_normals @ plane.normal) ** 2 < LEAST_IN_PLANE**2
    if not stretch.crease and leaning.any():
        return Problem(
            curve.normals.mark or curve.mark,
            f"curve '{curve.name}' lies in the mirror plane, but its normals point out of it by more than 60 degrees; "
            "give normals in the plane, or {left: ..., right: ...} for a crease",
        )
    return None


def _on_its_left(project: Project, curve: str) -> bool:
    """Whether the original patch along a shared curve lies on the curve's left."""
    originals = [project.patches[patch.mirror_of] for patch in project.patches.values() if patch.mirror_of]
    entries = [entry for patch in originals for loop in patch.loops for entry in loop]
    return next(not entry.reversed for entry in entries if entry.curve == curve)


def _in_plane(stretch: SampledStretch, plane: MirrorPlane, original_on_left: bool) -> SampledStretch:
    """A shared stretch with its vertices in the plane, and normals that are their own mirror image.

    At a crease the normals on the side of the image are the reflected ones of the original.
    """
    vertices = plane.foot(stretch.vertices)
    edges = unit(np.diff(vertices, axis=0))
    given = stretch.left_normals if original_on_left else stretch.right_normals
    if stretch.crease:
        kept = unit(given - dot(given, edges)[:, None] * edges)
        reflected = plane.reflect_directions(kept)
        left, right = (kept, reflected) if original_on_left else (reflected, kept)
    else:
        upright = unit(cross(edges, np.tile(plane.normal, (len(edges), 1))))
        left = right = np.copysign(1.0, dot(upright, given))[:, None] * upright
    return replace(stretch, vertices=vertices, left_normals=left, right_normals=right)


def _image(
    stretch: SampledStretch,
    plane: MirrorPlane,
    curve: str,
    across: Mapping[str, str],
    places: Mapping[str, Floats],
) -> SampledStretch:
    """A stretch on the other side; what was on its left is on its right. It ends in its nodes to the last bit."""
    start, end = (across.get(node, node) if node is not None else None for node in (stretch.start, stretch.end))
    vertices = plane.reflect(stretch.vertices)
    if start is not None and end is not None:
        vertices[0], vertices[-1] = places[start], places[end]
    left = plane.reflect_directions(stretch.right_normals)
    right = plane.reflect_directions(stretch.left_normals) if stretch.crease else left
    name = curve if stretch.name == stretch.curve else f"{curve}:{start}..{end}"
    return replace(
        stretch, name=name, curve=curve, start=start, end=end, vertices=vertices, left_normals=left, right_normals=right
    )


def images_of_boundary(original: BoundaryCurve, image: BoundaryCurve, plane: MirrorPlane) -> Ints:
    """Vertex i of the boundary -> that of the image's boundary, which runs the other way round, (n,); an involution.

    Both begin in the same vertex where the project makes an image; parts of divided patches begin elsewhere.
    """
    n = len(original.vertices)
    reflected = plane.reflect(original.vertices)
    apart = np.linalg.norm(image.vertices - reflected[0], axis=1)
    nearly = 1e-9 * np.abs(reflected).max()
    for first in np.argsort(apart, kind="stable")[:2]:  # the two sides of a slit are at the same place
        images = (first - np.arange(n)) % n
        if np.allclose(image.vertices[images], reflected, rtol=0.0, atol=nearly):
            return images
    raise AssertionError("the boundaries are images")


def image_of_cut(cut: Cut, original: BoundaryCurve, image: BoundaryCurve, plane: MirrorPlane) -> Cut:
    """The cut on the other side; it runs from the image of its end, so that what was on its left is on its left."""
    images = images_of_boundary(original, image, plane)
    start, end = int(images[cut.end]), int(images[cut.start])
    vertices = plane.reflect(cut.vertices)[::-1].copy()
    vertices[0], vertices[-1] = image.vertices[[start, end]]
    return Cut(start, end, vertices, plane.reflect_directions(cut.normals)[::-1].copy())
