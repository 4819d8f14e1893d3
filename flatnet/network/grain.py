"""The grain of a patch: a direction in space, or two vertices of its boundary between which it runs when flat."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.triangles import unit
from flatnet.network.graph import Dart
from flatnet.network.network import GeometryError, SampledStretch
from flatnet.network.patch import BoundaryCurve, Grain
from flatnet.project.patch_specs import PatchSpec, SignedCurve

Floats = NDArray[np.float64]


def make_grain(
    spec: PatchSpec, loop: Sequence[Dart], boundary: BoundaryCurve, stretches: Mapping[str, SampledStretch]
) -> Grain | None:
    """What `grain` says of a patch, on its boundary where the curve or both nodes are there, else in space.

    Raises
    ------
    GeometryError
        The curve ends where it starts, so that it has no direction; crossings are joined, but not in such a node.
    """
    if spec.grain is None:
        return None
    if spec.grain.direction is not None:
        return Grain(spec.grain.direction, said=spec.grain.said)
    if spec.grain.curve is None:
        assert spec.grain.nodes is not None, "a grain is a direction, a curve or two nodes"
        first, last = spec.grain.nodes
        known = {node for stretch in stretches.values() for node in (stretch.start, stretch.end)}
        for node in (first, last):
            if node not in known:
                message = f"patch '{spec.name}': grain: no curve passes a node '{node}'"
                raise GeometryError(spec.mark, message)
        starts = [_start(stretches[dart.stretch], dart) for dart in loop]
        if first in starts and last in starts:
            at = [boundary.stretches[starts.index(node)].first for node in (first, last)]
            return Grain(chord=(at[0], at[1]))
        return Grain(unit(_place(last, stretches) - _place(first, stretches)))
    return replace(_along(spec, spec.grain.curve, loop, boundary, stretches), said=spec.grain.said)


def _along(
    spec: PatchSpec,
    entry: SignedCurve,
    loop: Sequence[Dart],
    boundary: BoundaryCurve,
    stretches: Mapping[str, SampledStretch],
) -> Grain:
    """From where a curve first meets the patch to where it last does; in space, where it is not on its boundary."""
    names = [name for name, stretch in stretches.items() if stretch.curve == entry.curve]
    if entry.stretch:
        starts, ends = ([getattr(stretches[name], end) for name in names] for end in ("start", "end"))
        if entry.stretch[0] not in starts or entry.stretch[1] not in ends:
            message = f"patch '{spec.name}': grain: curve '{entry.curve}' has no stretch '{entry}'"
            raise GeometryError(entry.mark, message)
        names = names[starts.index(entry.stretch[0]) : ends.index(entry.stretch[1]) + 1] or names
    here = {dart.stretch: (dart, on) for dart, on in zip(loop, boundary.stretches, strict=True)}
    met = [here[name] for name in names if name in here]
    if met:
        n = len(boundary.vertices)
        (first, on), (last, last_on) = met[0], met[-1]
        start = (on.first + on.count) % n if first.reversed else on.first
        end = last_on.first if last.reversed else (last_on.first + last_on.count) % n
        if start != end:
            return Grain(chord=(end, start) if entry.reversed else (start, end))
    else:
        direction = stretches[names[-1]].vertices[-1] - stretches[names[0]].vertices[0]
        if direction.any():
            return Grain(unit(-direction if entry.reversed else direction))
    message = f"patch '{spec.name}': grain: curve '{entry.curve}' ends where it starts; name two nodes instead"
    raise GeometryError(entry.mark, message)


def _start(stretch: SampledStretch, dart: Dart) -> str | None:
    return stretch.end if dart.reversed else stretch.start


def _place(node: str, stretches: Mapping[str, SampledStretch]) -> Floats:
    """Where a node of the network is."""
    return next(
        stretch.vertices[end]
        for stretch in stretches.values()
        for name, end in ((stretch.start, 0), (stretch.end, -1))
        if name == node
    )
