"""The wrinkle measure on smooth, slack and wrinkled boundaries at two mesh sizes: what its threshold stands on."""

from __future__ import annotations

from typing import Any

import numpy as np

from flatnet.network.patch import BoundaryCurve
from flatnet.parameters import FairParameters
from tests.benchmark.boundaries import CASES, HOOKED
from tests.benchmark.fits import fit, sized_case
from tests.benchmark.random_boundaries import KINDS, random_case
from tests.benchmark.run import Options, map_in_children

#: Mesh sizes and normal weights: of the named boundaries, of the random ones.
NAMED, RANDOM = ((350, 1300), (1.0, 100.0)), ((400, 900), (1.0, 30.0))
#: Random boundaries of each kind.
EACH, EACH_QUICK = 12, 2


def run(options: Options) -> dict[str, Any]:
    names = [(name, -1) for name in CASES | HOOKED]
    names += [(kind, number) for kind in KINDS for number in range(EACH_QUICK if options.quick else EACH)]
    records = map_in_children(measured, names)

    def columns(family: tuple[tuple[int, ...], tuple[float, ...]]) -> list[str]:
        return ["case"] + [f"{size} V, weight {weight:g}" for weight in family[1] for size in family[0]]

    fixed = [record for record in records if record["kind"] not in KINDS]
    options.table("Turning, degrees: ridges + valleys, depth in mm at 100 mm per unit", columns(NAMED),
                  [[record["kind"], *map(told, record["turning"])] for record in fixed])  # fmt: skip
    options.table("Turning, degrees, of random boundaries: least, median, greatest", columns(RANDOM),
                  [[kind, *spans([r["turning"] for r in records if r["kind"] == kind])] for kind in KINDS])  # fmt: skip
    return {"fits": records}


def boundary_of(kind: str, number: int, vertices: int) -> tuple[BoundaryCurve, float]:
    return random_case(kind, number, vertices) if kind in KINDS else sized_case(kind, vertices)


def measured(named: tuple[str, int]) -> dict[str, Any]:
    """Every fit of one boundary; None where there is none."""
    kind, number = named
    turning = []
    sizes, weights = RANDOM if kind in KINDS else NAMED
    for weight in weights:
        for size in sizes:
            one = fit(kind, *boundary_of(kind, number, size), FairParameters(normal_weight=weight))
            wrinkles = one.fitted.mesh.wrinkles if one.fitted else None
            turning.append(
                None
                if wrinkles is None
                else (np.degrees(wrinkles.turning), wrinkles.ridges, wrinkles.valleys, wrinkles.depth)
            )
    return {"kind": kind, "number": number, "turning": turning}


def told(figures: tuple[float, int, int, float] | None) -> str:
    if figures is None:
        return "-"
    turning, ridges, valleys, depth = figures
    return f"{turning:.0f}: {ridges} + {valleys}, {depth:.1f}"


def spans(rows: list[list[tuple[float, int, int, float] | None]]) -> list[str]:
    columns = [[fit[0] for fit in column if fit] for column in zip(*rows, strict=True)]
    return [f"{min(column):.0f}, {np.median(column):.0f}, {max(column):.0f}" for column in columns]
