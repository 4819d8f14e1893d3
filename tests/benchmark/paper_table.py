"""Table 1 of the paper, its five examples, beside ours; and many small patches on two processes."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from flatnet.build import check
from flatnet.fitting.results import SurfaceMesh
from flatnet.network.patch import BoundaryCurve
from flatnet.parameters import FairParameters, FittingParameters
from tests.benchmark.boundaries import boundary_curve
from tests.benchmark.fits import edges_for, fit, shortcomings
from tests.benchmark.pictures import mesh_sheet
from tests.benchmark.random_boundaries import random_case
from tests.benchmark.run import BAND_MS, CHILDREN, Options, band_cholesky_ms, one_blas_thread
from tests.real.moai_hole import DATA as MOAI
from tests.real.moai_hole import moai_project

PROJECTS = Path(__file__).parents[2] / "projects"
#: Example -> seconds for the planar mesh, the warp and the flattenable mesh, vertices, triangles.
PAPER = {
    "wrinkle": (0.4, 0.3, 15.9, 654, 1226),
    "moai": (0.9, 2.5, 13.9, 1335, 2514),
    "pants": (1.7, 2.3, 4.2, 5010, 8572),
    "shoe I": (0.7, 1.5, 2.2, 1459, 2302),
    "shoe II": (0.7, 1.4, 1.7, 1460, 2276),
}
#: Wanted, all stages: the five examples together; 30 patches of 180 vertices on two processes, s.
WANTED, WANTED_SMALL = 4.0, 2.0
SMALL_PATCHES, SMALL_VERTICES, PROCESSES = 30, 180, 2
#: The sizes of the pieces of a shoe, more or less: vamps, strips and caps, 1,460 vertices together.
SHOE_PIECES = {"vamps": (235, 160, 160), "tubes": (125, 125, 105, 105, 75, 75, 55, 55), "caps": (105,)}
SHOE_PIECES_CUT = {"vamps": (210, 145), "tubes": (100, 100, 100, 100, 90, 90, 80, 80, 55, 55), "caps": (60, 60)}
#: Edge length with which the statue's patch gets as many vertices as the paper's, mm.
MOAI_EDGE = 76.5
RUNS = 3

#: A patch to fit: name, boundary, edge length, parameters.
Task = tuple[str, BoundaryCurve, float, FittingParameters]


def run(options: Options) -> dict[str, Any]:
    scale = BAND_MS / band_cholesky_ms()
    meshes: list[tuple[str, SurfaceMesh]] = []
    records = [measured(name, example, options, meshes) for name, example in EXAMPLES.items()]
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


def measured(
    name: str,
    example: Callable[[Path], tuple[str, list[Task]]],
    options: Options,
    meshes: list[tuple[str, SurfaceMesh]],
) -> dict[str, Any]:
    """All patches of an example; of several runs the one of median time. Its meshes are added to `meshes`."""
    source, tasks = example(options.folder)
    runs = [[fit(*task) for task in tasks] for _ in range(1 if options.quick else RUNS)]
    fits = sorted(runs, key=lambda run: sum(one.seconds for one in run))[len(runs) // 2]
    stages = {"2D": ("planar_boundary", "tessellation"), "warp": ("warp",), "FL": ("flattenable_mesh",)}
    stages["unfold"] = ("unfold",)
    short = {one.name: shortcomings(one.record) for one in fits}
    meshes += [(f"{name} {one.name}: E {one.record['E']:.0f}", one.fitted.mesh) for one in fits if one.fitted]
    return {
        "name": name,
        "source": source,
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


def shipped(*names: str) -> tuple[str, list[Task]] | None:
    """The tasks of a project of the repository, under one of these names."""
    for name in names:
        if (PROJECTS / name / "project.yaml").exists():
            return f"projects/{name}", of_project(PROJECTS / name / "project.yaml")
    return None


def wrinkle(_: Path) -> tuple[str, list[Task]]:
    return "projects/wrinkle", of_project(PROJECTS / "wrinkle" / "project.yaml")


def pants(_: Path) -> tuple[str, list[Task]]:
    return "projects/pants", of_project(PROJECTS / "pants" / "project.yaml")


def moai(folder: Path) -> tuple[str, list[Task]]:
    """The hole in the statue's back where its mesh is at hand, else an hourglass on an ellipsoid."""
    if (made := shipped("moai")) is not None:
        return made
    if MOAI.exists():
        [(name, boundary, _, parameters)] = of_project(moai_project(folder))
        return "the scan", [(name, boundary, MOAI_EDGE, parameters)]
    n = edges_for(hourglass, 1.2, PAPER["moai"][3])
    boundary = hourglass(n)
    return "an hourglass", [("back", boundary, 1.2 * mean_edge(boundary), FairParameters())]


def hourglass(n: int) -> BoundaryCurve:
    """A tall hourglass on an ellipsoid."""
    t = 2.0 * np.pi * np.arange(2 * n) / (2 * n)
    latitude = 1.1 * np.sin(t)
    longitude = (0.25 + 0.35 * (latitude / 1.1) ** 2) * np.cos(t)
    axes = np.array([1.0, 0.8, 1.6])
    sphere = np.c_[np.cos(latitude) * np.sin(longitude), -np.cos(latitude) * np.cos(longitude), np.sin(latitude)]
    points, normals = axes * sphere, sphere / axes
    return boundary_curve(points[::2], normals[1::2] / np.linalg.norm(normals[1::2], axis=1, keepdims=True))


def mean_edge(boundary: BoundaryCurve) -> float:
    return float(np.linalg.norm(np.roll(boundary.vertices, -1, axis=0) - boundary.vertices, axis=1).mean())


def shoe_1(_: Path) -> tuple[str, list[Task]]:
    return shipped("shoe-1", "shoe_1", "shoe") or ("like pieces", like_pieces(SHOE_PIECES))


def shoe_2(_: Path) -> tuple[str, list[Task]]:
    return shipped("shoe-2", "shoe_2") or ("like pieces", like_pieces(SHOE_PIECES_CUT))


def like_pieces(pieces: dict[str, tuple[int, ...]]) -> list[Task]:
    """Random boundaries of the kinds and sizes of a shoe's pieces."""
    return [
        (f"{kind}-{number}", *random_case(kind, number, vertices), FairParameters())
        for kind, sizes in pieces.items()
        for number, vertices in enumerate(sizes)
    ]


EXAMPLES: dict[str, Callable[[Path], tuple[str, list[Task]]]] = {
    "wrinkle": wrinkle, "moai": moai, "pants": pants, "shoe I": shoe_1, "shoe II": shoe_2,
}  # fmt: skip


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
