"""A cut as the lines of a project file that make it: nodes, the curve, and the two patches in place of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flatnet.fitting.results import FittedPatch
from flatnet.geometry.polygon import polyline_length
from flatnet.network.network import CurveNetwork, SampledStretch
from flatnet.network.patch import Patch
from flatnet.network.thickness import laid_back
from flatnet.parameters import METHODS
from flatnet.project.model import Project
from flatnet.project.patch_specs import AlsoSpec, GrainSpec, MarkSpec, PatchSpec
from flatnet.remedies.diagnose import Diagnosis, Result
from flatnet.remedies.ring_seam import RingSeam

Floats = NDArray[np.float64]

#: Significant digits of numbers: a micrometre on a kilometre.
DIGITS = 9
#: Coordinates below this part of the patch's size, and components below it of unit vectors, are the round-off of 0.
ROUND_OFF = 1e-12
#: Vertices of both parts that are nearer to each other, mm, are one of their seam.
SAME = 1e-6


def paste(project: Project, found: Diagnosis | RingSeam) -> str:
    """What to write into the project's file, in its units, to divide the patch, or open the ring, as was tried.

    The seam keeps the vertices that were tried. Seams with a new node on them are sampled anew on both sides of it, so
    that the fitted patches can differ slightly from those of the trial.
    """
    name = found.patch.name
    parts: tuple[Patch, ...]
    results: tuple[Result, ...]
    if isinstance(found, RingSeam):
        before, after, seam, parts, results = found.before, found.network, found.seam, (found.patch,), (found.result,)
    else:
        assert found.cure is not None, "there is a cut to paste"
        before, after, seam = found.network, found.cure.network, found.cure.seam
        parts, results = found.cure.parts, found.cure.results
    stretch = after.stretches[seam]
    new = [node for node in (stretch.start, stretch.end) if node is not None and node not in before.nodes]
    lines = ["nodes:"] if new else []
    for node in new:
        curve, t = _fraction(before, after.nodes[node])
        lines.append(f"  {node}: {{at: {{curve: {curve}, t: {t:.{DIGITS}g}}}}}")
    half = 0.5 * project.materials[parts[0].material].thickness
    size = float(np.ptp(np.concatenate([part.boundary.vertices for part in parts]), axis=0).max())
    lines += ["curves:", *_curve(stretch, half, size, project.mm_per_unit)]
    lines.append(f"patches:  # in place of '{name}'")
    spec = project.patches[name]
    lies_on = {mark.name: _parts_with(mark, results) for mark in spec.marks}
    for number, part in enumerate(parts):
        marks = [mark for mark in spec.marks if number in lies_on[mark.name]]
        entries = [*_patch(part, spec, project), *_corners(part, spec, after.stretches, stretch)]
        entries += _marks(marks, project.mm_per_unit)
        lines.append(f"  {part.name}: {{{', '.join(entries)}}}")
    lines += _left_to_say(spec, lies_on, stretch)
    if len(project.curves) == 1 and not project.openings and not project.rest_is_open:
        lines.append("rest: openings  # the other side of a closed curve goes without saying only where it is alone")
    return "\n".join(lines)


def _fraction(network: CurveNetwork, place: Floats) -> tuple[str, float]:
    """The curve that has a vertex at a place, and the fraction of its length there."""
    seam = next(s for s in network.stretches.values() if (s.vertices == place).all(axis=1).any())
    at = int(np.flatnonzero((seam.vertices == place).all(axis=1))[0])
    of_curve = [s for s in network.stretches.values() if s.curve == seam.curve]
    before = sum(s.length for s in of_curve[: of_curve.index(seam)])
    along = polyline_length(seam.vertices[: at + 1])
    return seam.curve, (before + along) / sum(s.length for s in of_curve)


def _curve(seam: SampledStretch, half: float, size: float, mm_per_unit: float) -> list[str]:
    points = [_vector(point / mm_per_unit, size / mm_per_unit) for point in laid_back(seam, half)]
    normals = [_vector(normal) for normal in seam.left_normals]
    return [
        f"  {seam.name}:",
        f"    from: {seam.start}",
        f"    to: {seam.end}",
        f"    points: [{', '.join(points)}]",
        f"    normals: {{per: segment, values: [{', '.join(normals)}]}}",
    ]


def _vector(values: Floats, size: float = 1.0) -> str:
    values = np.where(np.abs(values) < ROUND_OFF * size, 0.0, values)
    return "[" + ", ".join(f"{value:.{DIGITS}g}" for value in values) + "]"


def _parts_with(mark: MarkSpec, results: Sequence[Result]) -> tuple[int, ...]:
    """The numbers of the parts on which a mark lies; of all parts where it is as near to both, or one is not made."""
    everywhere = tuple(range(len(results)))
    made = [result.mesh.vertices for result in results if isinstance(result, FittedPatch)]
    if len(made) < len(results) or len(results) == 1:
        return everywhere
    away = np.array([cKDTree(vertices).query(np.array(mark.points))[0] for vertices in made])  # (parts, points)
    nearest = {int(part) for part in away.argmin(axis=0)}
    apart = bool((np.ptp(away, axis=0) > SAME).all())  # else a vertex of the seam between them is the nearest
    return tuple(nearest) if apart and len(nearest) == 1 else everywhere


def _marks(marks: Sequence[MarkSpec], mm_per_unit: float) -> list[str]:
    """The entry `marks` of a part."""
    said = []
    for mark in marks:
        size = float(np.abs(mark.points).max()) / mm_per_unit
        points = [_vector(point / mm_per_unit, size) for point in mark.points]
        entries = [f"at: {points[0]}" if len(points) == 1 else f"points: [{', '.join(points)}]", f"kind: {mark.kind}"]
        entries += [f"{key}: true" for key in ("spline", "closed") if getattr(mark, key)]
        if mark.diameter is not None:
            entries.append(f"diameter: {mark.diameter / mm_per_unit:.{DIGITS}g}")
        said.append(f"{mark.name}: {{{', '.join(entries)}}}")
    return [f"marks: {{{', '.join(said)}}}"] if said else []


def _corners(
    part: Patch, spec: PatchSpec, stretches: Mapping[str, SampledStretch], seam: SampledStretch
) -> list[str]:
    """The entry `min_angle` of a part: of the corners that it keeps; those at the ends of the seam are divided."""
    along = [stretches[run.seam] for run in part.boundary.stretches]
    kept = {node for each in along for node in (each.start, each.end)} - {seam.start, seam.end}
    said = [f"{node}: {np.degrees(angle):.{DIGITS}g}" for node, angle in spec.min_angles.items() if node in kept]
    return [f"min_angle: {{{', '.join(said)}}}"] if said else []


def _left_to_say(spec: PatchSpec, lies_on: Mapping[str, tuple[int, ...]], seam: SampledStretch) -> list[str]:
    """Comments on what could not be carried to one part."""
    both = [name for name, parts in lies_on.items() if len(parts) > 1]
    divided = [node for node in spec.min_angles if node in (seam.start, seam.end)]
    lines = []
    if both:
        lines.append(f"  # marks that are given to both parts, as they may lie on either: {', '.join(both)}")
    if divided:
        lines.append(f"  # min_angle is left out where the seam divides the corner: {', '.join(divided)}")
    return lines


def _also(every: Sequence[AlsoSpec], cut: int, mirrored: int, both: bool, mm_per_unit: float) -> list[str]:
    """The entry `also` of a part of which so many copies are cut; `both`: a left and a right one for each."""
    said = []
    for also in every:
        copies = (also.cut + also.mirrored,) * 2 if both else (also.cut, also.mirrored)
        entries = [f"cut: {copies[0]}", f"mirrored: {copies[1]}"] if copies != (cut, mirrored) else []
        if also.allowance is not None:
            entries.append(f"allowance: {also.allowance / mm_per_unit:.{DIGITS}g}")
        said.append(f"{also.material}: {{{', '.join(entries)}}}")
    return [f"also: {{{', '.join(said)}}}"] if said else []


def _patch(part: Patch, spec: PatchSpec, project: Project) -> list[str]:
    """The entries of a part: its loop, and what the whole patch said but for corners and marks."""
    around = ", ".join(("-" if s.reversed else "") + s.seam for s in part.boundary.stretches)
    entries = [f"around: [{around}]"]
    if len(project.materials) > 1:
        entries.append(f"material: {spec.material}")
    cut, mirrored = spec.cut, spec.mirrored
    on_fold = any(run.seam.partition(":")[0] == spec.fold for run in part.boundary.stretches)
    beside_fold = spec.fold is not None and not on_fold
    if on_fold:
        entries.append(f"fold: {spec.fold}")
    if beside_fold:  # there is a left and a right one
        cut = mirrored = cut + mirrored
    if (cut, mirrored) != (1, 0):
        entries += [f"cut: {cut}", f"mirrored: {mirrored}"]
    entries += _also(spec.also, cut, mirrored, beside_fold, project.mm_per_unit)
    if spec.allowance is not None:
        entries.append(f"allowance: {spec.allowance / project.mm_per_unit:.{DIGITS}g}")
    if spec.zone:
        entries.append(f"zone: {spec.zone}")
    if spec.match:
        entries.append("match: true")
    if spec.wrinkles_expected:
        entries.append("wrinkles: expected")
    if spec.simple_outline:
        entries.append("planar_boundary: simple")
    entries += _grain(spec.grain)
    if spec.edge_length != project.edge_length:
        entries.append(f"edge_length: {spec.edge_length / project.mm_per_unit:.{DIGITS}g}")
    method = next(name for name, cls in METHODS.items() if isinstance(spec.fitting, cls))
    usual = asdict(METHODS[method]())
    fitting = {key: value for key, value in asdict(spec.fitting).items() if value != usual[key]}
    if fitting or method != "fair":
        said = [f"method: {method}", *(f"{key}: {value:g}" for key, value in fitting.items())]
        entries.append(f"fitting: {{{', '.join(said)}}}")
    return entries


def _grain(grain: GrainSpec | None) -> list[str]:
    """What the patch says of its grain; nothing where it is as by default."""
    if grain is None:
        return ["grain: none"]
    if grain.curve is not None:
        return [f"grain: {{along: {grain.curve}}}"]
    if grain.nodes is not None:
        return [f"grain: {{from: {grain.nodes[0]}, to: {grain.nodes[1]}}}"]
    return [f"grain: {_vector(grain.direction)}"] if grain.said and grain.direction is not None else []
