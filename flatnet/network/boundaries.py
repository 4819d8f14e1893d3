"""Make the patches: join stretches to closed boundaries B with normals, and check that each bounds a disk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding
from flatnet.geometry.asked_curvature import asked_curvature
from flatnet.geometry.polygon import edge_vectors, predicted_angles
from flatnet.geometry.triangles import dot
from flatnet.network.grain import make_grain
from flatnet.network.graph import Dart
from flatnet.network.network import GeometryError, SampledStretch
from flatnet.network.patch import BoundaryCurve, Patch, Stretch
from flatnet.project.curve_specs import CurveSpec
from flatnet.project.patch_specs import PatchSpec
from flatnet.project.problems import Problem

Floats = NDArray[np.float64]

#: sum(alpha) - (n - 2) pi of a boundary that winds once is the total curvature of its patch, rad; of a figure
#: eight it is 2 pi more, of a loop run clockwise 4 pi, of one run twice 2 pi less. Patches that can be fitted lie
#: between -4.4 (a deep saddle) and 2.7.
LEAST_WINDING_EXCESS, LARGEST_WINDING_EXCESS = -5.5, 4.0
#: A normal that turns farther than this about the boundary from one edge to the next has changed side, rad;
#: less is a sharp fold across the boundary.
SIDE_CHANGE = np.radians(120.0)
#: Where the boundary turns back by 180 degrees less this, rad, its normals can't be compared.
TURNS_BACK = np.radians(1.0)


def make_patch(
    spec: PatchSpec,
    loops: Sequence[tuple[Dart, ...]],
    stretches: Mapping[str, SampledStretch],
    curves: Mapping[str, CurveSpec],
) -> tuple[Patch | Finding | None, list[Problem]]:
    """The patch on the left of its loop; a finding if it is no disk; None where the project is at fault."""
    if len(loops) > 1:
        return _several_loops(spec, loops), []
    [loop] = loops
    gap = open_gap(spec.name, loop, stretches)
    if gap is not None:
        return gap, []
    ends = [start_of(stretches[dart.stretch], dart) for dart in loop]
    problems = [
        Problem(spec.mark, f"patch '{spec.name}': min_angle at node '{node}', which is not on its boundary")
        for node in spec.min_angles
        if node not in ends
    ]
    boundary = join(loop, stretches, spec.min_angles)
    grain = None
    try:
        grain = make_grain(spec, loop, boundary, stretches)
    except GeometryError as found:
        problems.append(found.problem)
    problems += _side_changes(spec, boundary, stretches, curves)
    if problems:
        return None, problems
    return _winding(spec, boundary) or Patch(
        spec.name,
        boundary,
        spec.edge_length,
        spec.material,
        spec.cut,
        spec.mirrored,
        grain,
        spec.allowance,
        spec.wrinkles_expected,
        simple_outline=spec.simple_outline,
        mirror_of=spec.mirror_of,
        fold=spec.fold,
    ), []


def open_gap(patch: str, loop: Sequence[Dart], stretches: Mapping[str, SampledStretch]) -> Finding | None:
    """`open_boundary` where a stretch of a loop does not begin, to the last bit, where the last one ends."""
    for dart, following in zip(loop, [*loop[1:], loop[0]]):
        here = run_of(stretches[dart.stretch], dart)[0][-1]
        there = run_of(stretches[following.stretch], following)[0][0]
        gap = float(np.linalg.norm(there - here))
        if gap > 0.0:
            return Finding(
                code="open_boundary",
                stage="network",
                patch=patch,
                where=f"between '{dart}' and '{following}'",
                amount=gap,
                unit="mm",
                message=f"the boundary is open by {gap:.3g} mm between '{dart}' and '{following}'.",
                remedy="Let both curves end at one node.",
            )
    return None


def run_of(stretch: SampledStretch, dart: Dart) -> tuple[Floats, Floats]:
    """The stretch's vertices in the dart's direction, and the edge normals of the side on the dart's left."""
    if dart.reversed:
        return stretch.vertices[::-1], stretch.right_normals[::-1]
    return stretch.vertices, stretch.left_normals


def start_of(stretch: SampledStretch, dart: Dart) -> str | None:
    """The node where a dart begins; None on a closed stretch without node."""
    return stretch.end if dart.reversed else stretch.start


def join(
    loop: Sequence[Dart], stretches: Mapping[str, SampledStretch], min_angles: Mapping[str, float]
) -> BoundaryCurve:
    """The closed boundary along a loop of darts, one stretch for each.

    Parameters
    ----------
    min_angles : node -> smallest flat angle there, rad.
    """
    runs = [run_of(stretches[dart.stretch], dart) for dart in loop]
    counts = [len(normals) for _, normals in runs]
    firsts = np.concatenate([[0], np.cumsum(counts)]).astype(int)
    least = np.zeros(firsts[-1])
    for dart, first in zip(loop, firsts):
        least[first] = min_angles.get(start_of(stretches[dart.stretch], dart) or "", 0.0)
    return BoundaryCurve(
        vertices=np.concatenate([vertices[:-1] for vertices, _ in runs]),
        normals=np.concatenate([normals for _, normals in runs]),
        stretches=tuple(
            Stretch(dart.stretch, int(first), count, dart.reversed)
            for dart, first, count in zip(loop, firsts, counts)
        ),
        min_angles=least,
        slit_tips=tuple(
            int(firsts[i]) for i, dart in enumerate(loop) if loop[i - 1] == dart.opposite and len(loop) > 1
        ),
    )


def _several_loops(spec: PatchSpec, loops: Sequence[tuple[Dart, ...]]) -> Finding:
    return Finding(
        code="not_disk",
        stage="network",
        patch=spec.name,
        amount=float(len(loops)),
        unit="loops",
        message=f"it has {len(loops)} boundary loops; what can be flattened in one piece has one.",
        remedy="Join its loops by a curve from node to node: along it the patch is cut open.",
    )


def winds_once(boundary: BoundaryCurve) -> bool:
    """Whether the boundary winds once round its patch, anticlockwise seen against its normals."""
    return LEAST_WINDING_EXCESS <= _winding_excess(boundary) <= LARGEST_WINDING_EXCESS


def _winding_excess(boundary: BoundaryCurve) -> float:
    return asked_curvature(predicted_angles(boundary.vertices, boundary.normals)[0])


def _winding(spec: PatchSpec, boundary: BoundaryCurve) -> Finding | None:
    """`not_disk` where the boundary does not wind once round its patch."""
    if winds_once(boundary):
        return None
    excess = _winding_excess(boundary)
    turns = round(1.0 - excess / (2.0 * np.pi))
    reason, remedy = (
        ("it runs clockwise", "Turn the loop round in `around` if the other side is meant, or the normals.")
        if turns == -1
        else (f"it winds {turns} times", "Look for a curve that crosses another, or itself, without a node.")
    )
    return Finding(
        code="not_disk",
        stage="network",
        patch=spec.name,
        amount=excess,
        unit="rad",
        message=(
            f"its boundary should wind once, anticlockwise seen against its normals, but {reason}: the sum "
            f"of the predicted angles is {excess:+.2f} rad off that of a planar outline, "
            f"limits {LEAST_WINDING_EXCESS:g} and {LARGEST_WINDING_EXCESS:g}."
        ),
        remedy=remedy,
    )


def _side_changes(
    spec: PatchSpec,
    boundary: BoundaryCurve,
    stretches: Mapping[str, SampledStretch],
    curves: Mapping[str, CurveSpec],
) -> list[Problem]:
    """A problem for every curve whose normals stand on the other side than those of most of the boundary."""
    vertices, normals = boundary.vertices, boundary.normals
    edges = edge_vectors(vertices)
    lengths = np.linalg.norm(edges, axis=1)
    following = edges / lengths[:, None]
    previous = np.roll(following, 1, axis=0)
    before = np.roll(normals, 1, axis=0)
    # The least rotation that takes one edge's direction to the next takes its normal along.
    cosine = dot(previous, following)
    comparable = cosine > -np.cos(TURNS_BACK)
    lean = dot(before, following) / np.where(comparable, 1.0 + cosine, 1.0)
    transported = before - lean[:, None] * (previous + following)
    changes = comparable & (dot(transported, normals) < np.cos(SIDE_CHANGE))
    if not changes.any():
        return []
    side = np.cumsum(changes) % 2 == 1
    if lengths[side].sum() > 0.5 * lengths.sum():
        side = ~side
    curve_of = np.concatenate([[stretches[s.seam].curve] * s.count for s in boundary.stretches])
    problems = []
    for curve in dict.fromkeys(curve_of[side].tolist()):
        wrong = np.flatnonzero(side & (curve_of == curve))
        problems.append(
            Problem(
                curves[curve].normals.mark or curves[curve].mark,
                f"the normals of curve '{curve}' change side along patch '{spec.name}', from "
                f"{boundary.place(wrong[0])} on: {len(wrong)} of its {np.sum(curve_of == curve)} edges there "
                "stand against most of the boundary; turn them round",
            )
        )
    return problems
