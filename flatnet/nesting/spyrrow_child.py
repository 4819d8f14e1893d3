"""Run spyrrow in a process of its own: a strip packing problem as JSON on stdin, on stdout a line of JSON for each
better layout that it finds, and last its solution.

Run by path and free of imports of the package, so that it starts at once. Bad input makes the engine panic,
which reaches Python as a BaseException; whatever happens here, the caller reads it as {"error": ...}.
"""

import json
import sys
import threading

#: At most so often a better layout is told, s.
PAUSE = 1.0


def solve(problem: dict) -> dict:
    """The placements of a problem's items, as JSON has them; better layouts are told as they are found."""
    import spyrrow

    items = [
        spyrrow.Item(str(index), [tuple(p) for p in item["outline"]], item["count"], item["rotations"])
        for index, item in enumerate(problem["items"])
    ]
    config = spyrrow.StripPackingConfig(
        early_termination=False,
        min_items_separation=problem["separation"] or None,
        total_computation_time=problem["seconds"],
        num_workers=problem["workers"],
        seed=problem["seed"],
    )
    instance = spyrrow.StripPackingInstance("roll", problem["width"], items)
    queue = spyrrow.ProgressQueue()
    done = threading.Event()
    # The queue also delivers layouts in which pieces overlap.
    valid = (spyrrow.ReportType.ExplFeas, spyrrow.ReportType.CmprFeas)

    def tell() -> None:
        shortest = float("inf")
        while not done.wait(PAUSE):
            found = [solution for kind, solution in queue.drain() if kind in valid]
            best = min(found, key=lambda solution: solution.width, default=None)
            if best is not None and best.width < shortest:
                shortest = best.width
                print(json.dumps({"length": shortest, "placed": placements(best)}), flush=True)

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        solution = instance.solve(config, queue)
    finally:
        done.set()
        teller.join()
    return {"placed": placements(solution)}


def placements(solution) -> list:
    """Item, degrees, x and y of every copy."""
    return [[int(p.id), p.rotation, *p.translation] for p in solution.placed_items]


if __name__ == "__main__":
    try:
        answer = solve(json.load(sys.stdin))
    except BaseException as error:
        reason = str(error).partition("\n")[0]  # a panic brings its backtrace
        answer = {"error": f"{type(error).__name__}: {reason}"}
    print(json.dumps(answer), flush=True)
