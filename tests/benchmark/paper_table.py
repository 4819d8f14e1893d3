"""Table 1 of the paper, its five examples, beside ours; and many small patches on two processes."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from flatnet.build import check
from flatnet.fitting.results import SurfaceMesh
from flatnet.network.patch import BoundaryCurve
from flatnet.parameters import FairParameters, FittingParameters
from tests.benchmark.fits import fit, shortcomings
from tests.benchmark.pictures import mesh_sheet
from tests.benchmark.random_boundaries import random_case
from tests.benchmark.run import BAND_MS, CHILDREN, Options, band_cholesky_ms, one_blas_thread

PROJECTS = Path(__file__).parents[2] / "projects"
#: Example -> seconds for the planar mesh, the warp and the flattenable mesh, vertices, triangles.
PAPER = {
    "wrinkle": (0.4, 0.3, 15.9, 654, 1226),
    "moai": (0.9, 2.5, 13.9, 1335, 2514),
    "pants": (1.7, 2.3, 4.2, 5010, 8572),
    "shoe I": (0.7, 1.5, 2.2, 1459, 2302),
    "shoe II": (0.7, 1.4, 1.7, 1460, 2276),
}
#: Example -> its project.
EXAMPLES = {"wrinkle": "wrinkle", "moai": "moai", "pants": "pants", "shoe I": "shoe_1", "shoe II": "shoe_2"}
#: Wanted, all stages: the five examples together; 30 patches of 180 vertices on two processes, s.
WANTED, WANTED_SMALL = 4.0, 2.0
SMALL_PATCHES, SMALL_VERTICES, PROCESSES = 30, 180, 2
RUNS = 3

#: A patch to fit: name, boundary, edge length, parameters.
Task = tuple[str, BoundaryCurve, float, FittingParameters]


def run(options: Options) -> dict[str, Any]:
    scale = BAND_MS / band_cholesky_ms()
    meshes: list[tuple[str, SurfaceMesh]] = []
    records = [measured(name, project, options, meshes) for name, project in EXAMPLES.items()]
    rows = []
    for record in records:
        paper, seconds = PAPER[record["name"]], record["seconds"]
        rows.append([
            record["name"], record["source"], record["patches"], *paper, seconds["2D"], seconds["warp"],
            seconds["FL"], seconds["unfold"], record["vertices"], record["triangles"],
            sum(paper[:3]) / sum(seconds.values()), record["verdict"],
        ])  # fmt: skip
    columns = ("example", "ours is", "patches", "T_2D", "T_warp", "T_FL", "V", "F", "ours: T_2D", "T_warp", "T_FL",
               "unfold", "V", "F", "ratio", "verdict")  # fmt: skip
    options.table("Table 1: seconds of all patches together, the paper's and ours", columns, rows)
    total = sum(sum(record["seconds"].values()) for record in records)
    options.say(f"five examples: {total:.2f} s, scaled {scale * total:.2f} s; {WANTED:.0f} s wanted")
    small = small_patches()
    options.say(
        f"{small['patches']} patches of {small['vertices'] / small['patches']:.0f} vertices on {PROCESSES} processes: "
        f"{small['seconds']:.2f} s, scaled {scale * small['seconds']:.2f} s; {WANTED_SMALL:.0f} s wanted"
    )
    sheet = mesh_sheet(options.folder / "paper.png", meshes, 12)
    return {"scale": scale, "examples": records, "seconds": total, "small_patches": small, "sheet": str(sheet)}


def measured(name: str, project: str, options: Options, meshes: list[tuple[str, SurfaceMesh]]) -> dict[str, Any]:
    """All patches of an example; of several runs the one of median time. Its meshes are added to `meshes`."""
    tasks = of_project(PROJECTS / project / "project.yaml")
    runs = [[fit(*task) for task in tasks] for _ in range(1 if options.quick else RUNS)]
    fits = sorted(runs, key=lambda run: sum(one.seconds for one in run))[len(runs) // 2]
    stages = {"2D": ("planar_boundary", "tessellation"), "warp": ("warp",), "FL": ("flattenable_mesh",)}
    stages["unfold"] = ("unfold",)
    short = {one.name: shortcomings(one.record) for one in fits}
    meshes += [(f"{name} {one.name}: E {one.record['E']:.0f}", one.fitted.mesh) for one in fits if one.fitted]
    return {
        "name": name,
        "source": f"projects/{project}",
        "patches": len(fits),
        "vertices": sum(one.record.get("vertices", 0) for one in fits),
        "triangles": sum(one.record.get("triangles", 0) for one in fits),
        "seconds": {
            key: sum(one.record["seconds"].get(stage, 0.0) for one in fits for stage in names)
            for key, names in stages.items()
        },
        "verdict": "; ".join(f"{name}: {', '.join(words)}" for name, words in short.items() if words) or "all made",
        "fits": [one.record for one in fits],
    }


def of_project(file: Path) -> list[Task]:
    project, network = check(file)
    return [
        (patch.name, patch.boundary, patch.edge_length, project.patches[patch.name].fitting)
        for patch in network.patches
    ]


def small_patches() -> dict[str, Any]:
    """Thirty random boundaries of a garment's and a shoe's kinds, fitted by processes that are there already."""
    kinds = ("tubes", "vamps", "caps")
    tasks = [
        (f"{kind}-{number}", *random_case(kind, number, SMALL_VERTICES), FairParameters())
        for number in range(SMALL_PATCHES // len(kinds))
        for kind in kinds
    ]
    with CHILDREN.Pool(PROCESSES, initializer=one_blas_thread) as pool:
        pool.starmap(fit, tasks[:PROCESSES], chunksize=1)
        start = time.perf_counter()
        fits = pool.starmap(fit, tasks, chunksize=1)
        seconds = time.perf_counter() - start
    return {
        "patches": len(fits),
        "vertices": sum(one.record.get("vertices", 0) for one in fits),
        "seconds": seconds,
        "failed": {one.name: one.record["status"] for one in fits if one.fitted is None},
    }
