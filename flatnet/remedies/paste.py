"""A cut as the lines of a project file that make it: nodes, the curve, and the two patches in place of one."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.polygon import polyline_length
from flatnet.network.network import CurveNetwork, SampledStretch
from flatnet.network.patch import Patch
from flatnet.network.thickness import laid_back
from flatnet.parameters import METHODS
from flatnet.project.model import Project
from flatnet.project.patch_specs import GrainSpec, PatchSpec
from flatnet.remedies.diagnose import Diagnosis
from flatnet.remedies.ring_seam import RingSeam

Floats = NDArray[np.float64]

#: Significant digits of numbers: a micrometre on a kilometre.
DIGITS = 9
#: Coordinates below this part of the patch's size, and components below it of unit vectors, are the round-off of 0.
ROUND_OFF = 1e-12


def paste(project: Project, found: Diagnosis | RingSeam) -> str:
    """What to write into the project's file, in its units, to divide the patch, or open the ring, as was tried.

    The seam keeps the vertices that were tried. Seams with a new node on them are sampled anew on both sides of it, so
    that the fitted patches can differ slightly from those of the trial.
    """
    name = found.patch.name
    parts: tuple[Patch, ...]
    if isinstance(found, RingSeam):
        before, after, seam, parts = found.before, found.network, found.seam, (found.patch,)
    else:
        assert found.cure is not None, "there is a cut to paste"
        before, after, seam, parts = found.network, found.cure.network, found.cure.seam, found.cure.parts
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
    lines += [f"  {part.name}: {{{', '.join(_patch(part, project.patches[name], project))}}}" for part in parts]
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


def _patch(part: Patch, spec: PatchSpec, project: Project) -> list[str]:
    """The entries of a part: its loop, and what the whole patch said."""
    around = ", ".join(("-" if s.reversed else "") + s.seam for s in part.boundary.stretches)
    entries = [f"around: [{around}]"]
    if len(project.materials) > 1:
        entries.append(f"material: {spec.material}")
    cut, mirrored = spec.cut, spec.mirrored
    if spec.fold is not None and spec.fold in (s.seam.partition(":")[0] for s in part.boundary.stretches):
        entries.append(f"fold: {spec.fold}")
    elif spec.fold is not None:  # beside the fold there is a left and a right one
        cut = mirrored = cut + mirrored
    if (cut, mirrored) != (1, 0):
        entries += [f"cut: {cut}", f"mirrored: {mirrored}"]
    if spec.allowance is not None:
        entries.append(f"allowance: {spec.allowance / project.mm_per_unit:.{DIGITS}g}")
    if spec.zone:
        entries.append(f"zone: {spec.zone}")
    if spec.match:
        entries.append("match: true")
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
