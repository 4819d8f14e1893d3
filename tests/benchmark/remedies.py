"""Random strips that cover themselves when they are laid flat: how many the automatic split cures."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from flatnet.fitting.results import FailedPatch
from flatnet.fitting.run import run_patch
from flatnet.network.patch import Patch
from flatnet.parameters import FairParameters
from flatnet.remedies.auto_split import MAX_DEPTH, split
from flatnet.remedies.diagnose import Result
from tests.benchmark.run import Options, map_in_children
from tests.crossing import crossing_boundary, network_of

STRIPS, STRIPS_QUICK = 20, 4


def run(options: Options) -> dict[str, Any]:
    records = map_in_children(cured, range(STRIPS_QUICK if options.quick else STRIPS))
    options.table(
        "Strips that cross themselves, and the automatic split",
        ["seed", "as a whole", "parts", "not made", "mm of cuts", "s"],
        [[r["seed"], r["whole"], r["parts"], r["unmade"], r["cuts_mm"], r["seconds"]] for r in records],
    )
    crossing = [record for record in records if record["whole"] == "self_intersection"]
    made = sum(record["unmade"] == 0 for record in crossing)
    options.say(f"cured: {made} of {len(crossing)} that cross themselves, of {len(records)} strips")
    return {"strips": records, "crossing": len(crossing), "cured": made}


def fit_all(patches: Sequence[Patch]) -> list[Result]:
    return [run_patch(patch, FairParameters()) for patch in patches]


def cured(seed: int) -> dict[str, Any]:
    start = time.process_time()
    network = network_of(*crossing_boundary(seed))
    [patch] = network.patches
    [whole] = fit_all([patch])
    divided, parts, _ = split(network, patch, whole, None, fit_all, MAX_DEPTH)
    cuts = [stretch.length for stretch in divided.stretches.values() if "_cut" in stretch.curve]
    return {
        "seed": seed,
        "whole": whole.failure.code if isinstance(whole, FailedPatch) else "made",
        "parts": len(parts),
        "unmade": sum(isinstance(part, FailedPatch) for part in parts.values()),
        "cuts_mm": sum(cuts),
        "seconds": time.process_time() - start,
    }
