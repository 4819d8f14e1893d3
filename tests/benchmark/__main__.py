"""Measure everything: `python -m tests.benchmark [--part NAME ...] [--quick] [--large] [--out FOLDER]`."""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from rich.console import Console

from tests.benchmark.run import Options, band_cholesky_ms, one_blas_thread

#: Part -> the module whose `run` measures it, in the order of a whole run.
PARTS = {
    "boundaries": "fairness",
    "random": "random_family",
    "scaling": "scaling",
    "paper": "paper_table",
    "multi_loop": "against_multi_loop",
    "flattening": "flattening",
    "stages": "large_stages",
    "wrinkles": "wrinkles",
    "remedies": "remedies",
    "nesting": "nesting",
    "figures": "figures",
}


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmark", description="Measure flatnet's fitting.")
    parser.add_argument("--part", action="append", choices=PARTS, help="only this part; can be repeated")
    parser.add_argument("--quick", action="store_true", help="less of everything, in about three minutes")
    parser.add_argument("--large", action="store_true", help="meshes of 100,000 vertices too")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="folder for bench.json and pictures")
    arguments = parser.parse_args()
    folder: Path = arguments.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    # A terminal of 80 columns would cut the tables; a file or a pipe has no width of its own.
    console = Console() if sys.stdout.isatty() else Console(width=190)
    options = Options(folder, arguments.quick, arguments.large, console)
    one_blas_thread()
    result: dict[str, Any] = {"machine": machine(), "quick": options.quick, "parts": {}}
    options.say(", ".join(f"{key}: {value}" for key, value in result["machine"].items()))
    file = folder / "bench.json"
    for part in arguments.part or PARTS:
        start = time.perf_counter()
        measure: Callable[[Options], dict[str, Any]] = import_module(f"tests.benchmark.{PARTS[part]}").run
        result["parts"][part] = measure(options)
        result["parts"][part]["part_seconds"] = time.perf_counter() - start
        options.say(f"{part}: {time.perf_counter() - start:.0f} s\n")
        file.write_text(json.dumps(result, indent=1, default=float) + "\n", encoding="utf-8")
    options.say(f"all figures: {file}")
    return 0


def machine() -> dict[str, Any]:
    """What the times were measured on."""
    return {
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "python": platform.python_version(),
        "load": [round(load, 1) for load in os.getloadavg()],
        "band_cholesky_ms": round(band_cholesky_ms(), 2),
    }


def processor() -> str:
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


if __name__ == "__main__":
    sys.exit(main())
