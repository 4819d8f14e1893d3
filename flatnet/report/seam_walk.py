"""Walking the seams: sew lines that are sewn together, compared from notch to notch on the flat pieces."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding
from flatnet.fitting.results import FittedPatch
from flatnet.geometry.polygon import arclengths
from flatnet.network.network import CurveNetwork
from flatnet.pattern.notches import SeamNotch
from flatnet.pattern.seams import Seam
from flatnet.pattern.sewn import Join, Place, Run
from flatnet.report.seams import side_vertices

Floats = NDArray[np.float64]

#: The most, mm, by which sew lines may differ from what is declared (1/16 inch: what the trade accepts at the most).
TOLERANCE = 1.6


def walk_records(
    network: CurveNetwork, seams: Mapping[str, Seam], fitted: Mapping[str, FittedPatch]
) -> list[dict[str, object]]:
    """The `seam_walk` of report.json: every seam with two sides that are made, and curves sewn to other curves."""
    walked: dict[str, list[Floats]] = {name: [] for name in seams}  # of each side, in the order of the patches
    for patch in network.patches:
        if patch.name in fitted:
            outline = fitted[patch.name].outline
            for stretch in patch.boundary.stretches:
                walked[stretch.seam].append(arclengths(outline[side_vertices(stretch, len(outline))]))
    records = [
        _record(name, name, _legs(sides[0], seams[name].notches), _legs(sides[1], seams[name].notches), 0.0)
        for name, sides in walked.items()
        if len(sides) == 2
    ]
    joins = dict.fromkeys(found for seam in seams.values() for found in seam.joins)
    return records + [_joined(found, walked) for found in joins if _is_made(found, walked)]


def _is_made(join: Join, walked: Mapping[str, list[Floats]]) -> bool:
    return all(walked.get(name) for name, _ in (*join.eased.seams, *join.plain.seams))


def _joined(join: Join, walked: Mapping[str, list[Floats]]) -> dict[str, object]:
    first = _along(join.eased, [eased for eased, _ in join.matches], walked)
    second = _along(join.plain, [plain for _, plain in join.matches], walked)
    return _record(str(join.eased), str(join.plain), np.diff(first), np.diff(second), join.ease)


def _along(run: Run, places: Iterable[Place], walked: Mapping[str, list[Floats]]) -> Floats:
    """Arclengths on the whole flat pieces of a run's start, of places on it, and of its end."""
    starts, total = {}, 0.0
    for name, _ in run.seams:
        starts[name] = total
        total += float(walked[name][0][-1])
    back = dict(run.seams)
    found = []
    for name, notch, image in places:
        along = walked[name][0]
        place = notch.met_at(along)
        drawn = starts[name] + (float(along[-1]) - place if back[name] else place)
        found.append(run.along(drawn, image, total))
    return np.array([0.0, *found, total if run.fold is None else 2.0 * total])


def _legs(along: Floats, notches: Iterable[SeamNotch]) -> Floats:
    """Lengths from a seam's start to its first notch, from there to the next ... to its end."""
    return np.diff([0.0, *(notch.met_at(along) for notch in notches), float(along[-1])])


def _record(first: str, second: str, a: Floats, b: Floats, ease: float) -> dict[str, object]:
    """`a`, `b` : lengths from notch to notch, mm; `ease` : by how much the sum of the first is to be more."""
    total = float(a.sum() - b.sum())
    even = b * (1.0 + ease / float(b.sum()))
    warning = _ease_off(first, second, total, ease, float(b.sum())) if abs(total - ease) > TOLERANCE else None
    return {
        "a": first,
        "b": second,
        "length_a_mm": float(a.sum()),
        "length_b_mm": float(b.sum()),
        "ease_mm": total,
        "declared_ease_mm": ease,
        "legs": [{"a_mm": x, "b_mm": y} for x, y in zip(a.tolist(), b.tolist(), strict=True)],
        "largest_difference_mm": float(np.abs(a - even).max()),
        "warnings": [warning.as_dict()] if warning else [],
    }


def _ease_off(first: str, second: str, ease: float, declared: float, length: float) -> Finding:
    def spoken(mm: float) -> str:
        return f"{mm:.1f} mm ({100.0 * mm / length:.1f} %)"

    return Finding(
        code="ease_off",
        stage="report",
        where=f"'{first}'",
        amount=ease - declared,
        unit="mm",
        message=f"'{first}' is {spoken(abs(ease))} {'longer' if ease >= 0.0 else 'shorter'} than '{second}', to which "
        f"it is sewn; an ease of {spoken(declared)} is declared.",
        remedy="Say what is meant in `ease` of its `sewn_to`, or draw one of both longer.",
    )
