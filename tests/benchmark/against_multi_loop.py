"""The default method against Algorithm 1 as printed: time to the same residual, side by side."""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np

from flatnet.fitting.multi_loop import multi_loop
from flatnet.parameters import FairParameters, MultiLoopParameters
from tests.benchmark.boundaries import CASES, HOOKED
from tests.benchmark.fits import fit, initial_meshes, sized_case
from tests.benchmark.run import Options, in_child

VERTICES = 650
#: Both have to reach this worst flattenability, rad.
TOLERANCE = FairParameters().tolerance
#: Seconds that Algorithm 1 is given; the ratio wanted.
CAP, CAP_QUICK, RATIO = 60.0, 10.0, 20.0
QUICK = ("w12", "saddle", "vamp", "cap")
#: The default method is run so often, the median counts; outer loops of the run that measures their speed.
RUNS, PROBE = 5, 4
#: Algorithm 1 is run as often where it gets there in less than this, s.
SHORT = 5.0


def run(options: Options) -> dict[str, Any]:
    cap = CAP_QUICK if options.quick else CAP
    records = [compared(name, cap) for name in (QUICK if options.quick else CASES | HOOKED)]
    options.table(
        f"The default against Algorithm 1, both to {TOLERANCE:.0e} rad or {cap:.0f} s; seconds of the stage alone",
        ("case", "V", "steps", "s", "c", "steps (Alg. 1)", "s", "c", "ended", "ratio", "verdict"),
        [row(record) for record in records],
    )
    ratios = [record["ratio"] for record in records if record["ratio"] is not None]
    if ratios:
        options.say(f"median ratio {statistics.median(ratios):.0f}, least {min(ratios):.0f}; {RATIO:.0f} wanted")
    return {"cap": cap, "tolerance": TOLERANCE, "fits": records}


def compared(name: str, cap: float) -> dict[str, Any]:
    """Both methods on one boundary; one that gives up early or never gets there counts as `cap` seconds."""
    child = in_child(fair_seconds, name)
    if child.result is None:
        raise RuntimeError(f"{name}: {child.error}")
    ours = child.result
    theirs = in_child(multi_loop_run, name, cap, limit=3.0 * cap).result
    if theirs is None:
        theirs = {"steps": None, "c": None, "seconds": cap, "status": "stopped"}
    reached = theirs["status"] == "converged"
    seconds = theirs["seconds"] if reached else cap
    ratio = seconds / ours["seconds"] if ours["status"] == "ok" else None
    return {"name": name, "fair": ours, "multi_loop": theirs, "ratio": ratio, "reached": reached}


def fair_seconds(name: str) -> dict[str, Any]:
    """The record of the default method with the median time of its stage."""
    boundary, edge_length = sized_case(name, VERTICES)
    records = [fit(name, boundary, edge_length).record for _ in range(RUNS)]
    seconds = float(np.median([record["seconds"]["flattenable_mesh"] for record in records]))
    return records[0] | {"seconds": seconds, "stages": records[0]["seconds"]}


def multi_loop_run(name: str, cap: float) -> dict[str, Any]:
    """Algorithm 1 for about `cap` seconds: a short run tells how many outer loops that is."""
    boundary, edge_length = sized_case(name, VERTICES)
    planar, warped = initial_meshes(boundary, edge_length)

    def timed(outer_loops: int):
        parameters = MultiLoopParameters(tolerance=TOLERANCE, max_outer_loops=outer_loops)
        start = time.perf_counter()
        return multi_loop(warped, boundary, planar, parameters), time.perf_counter() - start

    mesh, seconds = timed(PROBE)
    if mesh.status == "outer loop limit":
        mesh, seconds = timed(max(PROBE, round(PROBE * cap / seconds)))
    if mesh.status == "converged" and seconds < SHORT:
        outer_loops = mesh.parameters["max_outer_loops"]
        seconds = float(np.median([seconds, *(timed(outer_loops)[1] for _ in range(RUNS - 1))]))
    return {"steps": mesh.steps, "c": mesh.max_flattenability, "seconds": seconds, "status": mesh.status}


def row(record: dict[str, Any]) -> list[object]:
    ours, theirs, ratio = record["fair"], record["multi_loop"], record["ratio"]
    verdict = "short" if ratio is None or ratio < RATIO else "beat"
    at_least = "" if record["reached"] else ">= "
    return [
        record["name"], ours.get("vertices"), ours.get("steps"), ours["seconds"], ours.get("c"),
        theirs["steps"], theirs["seconds"], theirs["c"], theirs["status"],
        f"{at_least}{ratio:.0f}" if ratio is not None else ours["status"], verdict,
    ]  # fmt: skip
