"""The stages before the fit on large input: processor time and peak memory of each."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.warp import warp
from tests.benchmark.boundaries import case
from tests.benchmark.fits import sized_case
from tests.benchmark.run import BAND_MS, Options, band_cholesky_ms, in_child

GIB = 2**30
#: A stage that has not ended by then is stopped, s.
LIMIT = 300.0
#: The mesh of the warp's boundary is coarser than the boundary, in boundary edges.
WARP_EDGE = 4.0


def planar_boundary(edges: int) -> dict[str, Any]:
    boundary, _ = case("w12", edges)
    start = time.process_time()
    fit_planar_boundary(boundary)
    return {"seconds": time.process_time() - start, "size": len(boundary.vertices)}


def tessellation(vertices: int) -> dict[str, Any]:
    boundary, edge_length = sized_case("w12", vertices)
    planar_boundary = fit_planar_boundary(boundary)
    start = time.process_time()
    planar = tessellate(planar_boundary, edge_length)
    return {"seconds": time.process_time() - start, "size": len(planar.positions)}


def warped(edges: int) -> dict[str, Any]:
    boundary, edge_length = case("w12", edges)
    planar = tessellate(fit_planar_boundary(boundary), WARP_EDGE * edge_length / 1.3)
    start = time.process_time()
    warp(planar, boundary)
    return {
        "seconds": time.process_time() - start,
        "size": len(boundary.vertices),
        "mesh_vertices": len(planar.positions),
    }


#: Stage -> what measures it, the size, the size in a quick run, the seconds and the bytes wanted.
STAGES: dict[str, tuple[Callable[[int], dict[str, Any]], int, int, float, float | None]] = {
    "warp, boundary edges": (warped, 2000, 500, 5.0, GIB),
    "planar boundary, edges": (planar_boundary, 10_000, 10_000, 1.0, None),
    "tessellation, vertices": (tessellation, 100_000, 10_000, 10.0, None),
}


def run(options: Options) -> dict[str, Any]:
    scale = BAND_MS / band_cholesky_ms()
    records, rows = [], []
    for name, (measure, size, quick_size, seconds, memory) in STAGES.items():
        child = in_child(measure, quick_size if options.quick else size, limit=LIMIT)
        record = child.result or {"size": size, "seconds": child.seconds, "status": child.error.splitlines()[-1]}
        record |= {"stage": name, "peak_bytes": child.peak}
        records.append(record)
        short = [record["status"]] if child.result is None else []
        short += ["time"] * (scale * record["seconds"] > seconds)
        short += ["memory"] * (memory is not None and child.peak > memory)
        megabytes = [value / 2**20 if value else None for value in (child.peak, memory)]
        rows.append([
            name, record["size"], record.get("mesh_vertices"), record["seconds"], scale * record["seconds"], seconds,
            *megabytes, "short: " + ", ".join(short) if short else "beat",
        ])  # fmt: skip
    columns = ("stage", "size", "mesh V", "s", "scaled", "wanted", "MiB", "wanted", "verdict")
    options.table("Stages on large input (memory of the whole process)", columns, rows)
    return {"scale": scale, "stages": records}
