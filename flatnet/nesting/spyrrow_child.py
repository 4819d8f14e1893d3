"""Run spyrrow in a process of its own: a strip packing problem as JSON on stdin, its solution on stdout.

Run by path and free of imports of the package, so that it starts at once. Bad input makes the engine panic,
which reaches Python as a BaseException; whatever happens here, the caller reads it as {"error": ...}.
"""

import json
import sys


def solve(problem: dict) -> dict:
    """The placements of a problem's items, as JSON has them."""
    import spyrrow

    items = [
        spyrrow.Item(str(index), [tuple(p) for p in item["outline"]], item["count"], item["rotations"])
        for index, item in enumerate(problem["items"])
    ]
    config = spyrrow.StripPackingConfig(
        early_termination=False,
        min_items_separation=problem["separation"],
        total_computation_time=problem["seconds"],
        num_workers=problem["workers"],
        seed=problem["seed"],
    )
    solution = spyrrow.StripPackingInstance("roll", problem["width"], items).solve(config)
    return {"placed": [[int(p.id), p.rotation, *p.translation] for p in solution.placed_items]}


if __name__ == "__main__":
    try:
        answer = solve(json.load(sys.stdin))
    except BaseException as error:
        reason = str(error).partition("\n")[0]  # a panic brings its backtrace
        answer = {"error": f"{type(error).__name__}: {reason}"}
    json.dump(answer, sys.stdout)
