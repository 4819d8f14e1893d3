"""How time and memory grow with the mesh: seconds of each stage, peak memory, exponents."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.benchmark.fits import fit, shortcomings, sized_case
from tests.benchmark.run import BAND_MS, Options, band_cholesky_ms, in_child

FAMILIES = ("w12", "vamp")
SIZES, QUICK, LARGE = (650, 1500, 2500, 6000, 25_000), 2, 100_000
#: Wanted seconds of all stages, where the band Cholesky takes `BAND_MS`; growth, memory in bytes.
WANTED = {650: 0.2, 1500: 0.5, 2500: 1.0, 6000: 4.0, 25_000: 45.0}
EXPONENT, MEMORY = 1.5, 8 * 2**30
STAGES = ("planar_boundary", "tessellation", "warp", "flattenable_mesh", "unfold")
#: A run is repeated while it is shorter than this, s; the median counts.
SHORT, RUNS = 5.0, 3
#: A fit that has not ended by then is stopped, s.
LIMIT, LIMIT_LARGE = 400.0, 3600.0


def run(options: Options) -> dict[str, Any]:
    sizes = SIZES[:QUICK] if options.quick else SIZES + (LARGE,) * options.large
    band = band_cholesky_ms()
    records, exponents = [], {}
    for family in FAMILIES:
        of_family = [measured(family, size) for size in sizes]
        records += of_family
        made = [record for record in of_family if record["status"] == "ok"]
        if len(made) > 1:
            exponents[family] = {stage: exponent(made, stage) for stage in (*STAGES, "all")}
    options.say(f"band Cholesky at 636 vertices: {band:.2f} ms; scaled = seconds x {BAND_MS / band:.2f}")
    rows = [row(record, BAND_MS / band) for record in records]
    for family, fitted in exponents.items():
        rows.append([f"{family}: n^", None, None, *fitted.values(), None, f"<= {EXPONENT}"])
    columns = ["case", "V", "steps", *STAGES, "all", "scaled", "wanted", "MiB", "verdict"]
    options.table("Scaling: seconds of each stage, peak memory of the process", columns, rows)
    return {"band_cholesky_ms": band, "scale": BAND_MS / band, "fits": records, "exponents": exponents}


def measured(family: str, size: int) -> dict[str, Any]:
    """The fit of one size in a child process."""
    child = in_child(fitted_size, family, size, limit=LIMIT_LARGE if size >= LARGE else LIMIT)
    if child.result is None:
        error = child.error.splitlines()[-1]
        return {"name": family, "size": size, "status": error, "seconds": {}, "short": [error]}
    return child.result | {"size": size, "peak_bytes": child.peak, "short": shortcomings(child.result)}


def fitted_size(family: str, size: int) -> dict[str, Any]:
    """The record of the fit of median time."""
    boundary, edge_length = sized_case(family, size)
    fits = [fit(family, boundary, edge_length)]
    if fits[0].seconds < SHORT:
        fits += [fit(family, boundary, edge_length) for _ in range(RUNS - 1)]
    return sorted(fits, key=lambda one: one.seconds)[len(fits) // 2].record


def exponent(records: list[dict[str, Any]], stage: str) -> float:
    """p of seconds = a V^p, by least squares in the logarithms."""
    seconds = [sum(r["seconds"].values()) if stage == "all" else r["seconds"][stage] for r in records]
    return float(np.polyfit(np.log([r["vertices"] for r in records]), np.log(seconds), 1)[0])


def row(record: dict[str, Any], scale: float) -> list[object]:
    seconds = record["seconds"]
    total = sum(seconds.values()) if seconds else np.inf
    wanted = WANTED.get(record["size"])
    short = list(record["short"])
    if wanted is not None and not scale * total <= wanted:
        short.append("time")
    if record.get("peak_bytes", 0) > MEMORY:
        short.append("memory")
    peak = record.get("peak_bytes", 0) / 2**20
    return [
        record["name"], record.get("vertices", record["size"]), record.get("steps"),
        *(seconds.get(stage) for stage in STAGES), total, scale * total, wanted, peak,
        "short: " + ", ".join(short) if short else "beat",
    ]  # fmt: skip
