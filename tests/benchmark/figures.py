"""Fig. 6 and Fig. 7 of the paper: what the cross-tangent points do; how fast flattenability falls, three ways."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flatnet.fitting.fair import fit_fair
from flatnet.fitting.multi_loop import multi_loop
from flatnet.fitting.planar_boundary import fit_planar_boundary
from flatnet.fitting.results import FlattenableMesh, WarpedMesh
from flatnet.fitting.tessellation import tessellate
from flatnet.fitting.warp import warp
from flatnet.geometry.triangles import angles_between, boundary_triangle_normals
from flatnet.network.patch import BoundaryCurve
from flatnet.parameters import FairParameters, MultiLoopParameters
from flatnet.report.panels import Panel, flattenability_panel, shaded_panel
from flatnet.report.view import Surface, cameras
from tests.benchmark.fits import initial_meshes, sized_case
from tests.benchmark.pictures import panel_sheet
from tests.benchmark.run import Options, median_seconds

VERTICES = 650
FIG_6 = ("w12", "saddle", "vamp", "pants", "hook")
FIG_7 = "hook"
#: Accumulated steps after which the flattenability is taken; the numbers of the figure among them.
STEPS = (5, 10, 25, 50, 100, 200, 400, 800)
STEPS_QUICK = STEPS[:5]
#: Flattenability that the default method is asked for, rad.
TOLERANCES = np.geomspace(1e-1, 1e-11, 11)
SMALLEST = 1e-16
#: A run shorter than this, s, is repeated, the median counts.
SHORT, RUNS = 1.0, 3
#: Meshes of each method in the picture.
SHOWN = 3

#: Steps, seconds, worst flattenability.
Trace = list[tuple[int, float, float]]


def run(options: Options) -> dict[str, Any]:
    return {"fig_6": cross_tangents(options), "fig_7": convergence(options)}


def cross_tangents(options: Options) -> dict[str, Any]:
    """Normals of M^0 at the boundary, warped with and without T_out and T_in (Fig. 6)."""
    records, panels = [], []
    for name in FIG_6:
        boundary, edge_length = sized_case(name, VERTICES)
        planar = tessellate(fit_planar_boundary(boundary), edge_length)
        record: dict[str, Any] = {"name": name, "vertices": len(planar.positions)}
        views = None
        for key, cross in (("without", False), ("with", True)):
            warped = warp(planar, boundary, cross_tangents=cross)
            record[key] = deviations(warped, boundary)
            surface = Surface.of([warped])
            views = views or cameras(surface)
            caption = f"{name} {key} cross-tangents: normals off by {record[key]['mean']:.1f} deg"
            panels += [shaded_panel(caption if k == 0 else "", surface, view) for k, view in enumerate(views)]
        records.append(record)
    columns = ("case", "V", "without: mean", "max", "with: mean", "max")
    options.table(
        "Fig. 6: normals of the warped mesh off the given ones, degrees, without and with cross-tangent points",
        columns,
        [[r["name"], r["vertices"], *r["without"].values(), *r["with"].values()] for r in records],
    )
    return {"fits": records, "picture": str(panel_sheet(options.folder / "fig_6.png", panels, 4))}


def deviations(mesh: WarpedMesh, boundary: BoundaryCurve) -> dict[str, float]:
    normals = boundary_triangle_normals(mesh.vertices, mesh.triangles, mesh.boundary_count)
    angles = np.degrees(angles_between(normals, boundary.normals))
    return {"mean": float(angles.mean()), "max": float(angles.max())}


def convergence(options: Options) -> dict[str, Any]:
    """Direct Newton, the multi-loop and the default method on the hooked outline (Fig. 7)."""
    boundary, edge_length = sized_case(FIG_7, VERTICES)
    planar, warped = initial_meshes(boundary, edge_length)
    printed = MultiLoopParameters(tolerance=1e-13)
    inner = printed.inner_steps
    most = STEPS_QUICK if options.quick else STEPS
    methods: dict[str, Callable[[float], FlattenableMesh]] = {
        "direct Newton": lambda steps: multi_loop(
            warped, boundary, planar, replace(printed, inner_steps=int(steps), max_outer_loops=1)
        ),
        "multi-loop": lambda steps: multi_loop(
            warped, boundary, planar, replace(printed, max_outer_loops=int(steps) // inner)
        ),
        "default": lambda tolerance: fit_fair(warped, boundary, planar, FairParameters(tolerance=tolerance)),
    }
    start = (0, 0.0, warped.max_flattenability)
    traces: dict[str, Trace] = {}
    panels: list[Panel] = []
    view = cameras(Surface.of([warped]))[0]
    for name, method in methods.items():
        trace, meshes = traced(method, TOLERANCES if name == "default" else most)
        traces[name] = [start, *trace]
        panels.append(flattenability_panel(f"M^0: worst {warped.max_flattenability:.1e}", Surface.of([warped]), view))
        for index in picked(len(meshes)):
            caption = f"{name}, {trace[index][0]} steps: worst {trace[index][2]:.1e}"
            panels.append(flattenability_panel(caption, Surface.of([meshes[index]]), view))
    columns = ("method", "steps", "s", "worst flattenability")
    options.table("Fig. 7: the hooked outline, worst flattenability over steps and seconds", columns, [
        [name, *point] for name, trace in traces.items() for point in trace
    ])  # fmt: skip
    return {
        "vertices": len(warped.vertices),
        "traces": traces,
        "plot": str(plot(options.folder / "fig_7.png", traces)),
        "picture": str(panel_sheet(options.folder / "fig_7_meshes.png", panels, 1 + SHOWN)),
    }


def picked(count: int) -> list[int]:
    """Up to `SHOWN` indices, spread, the last among them."""
    return sorted({round(k) for k in np.linspace(0, count - 1, SHOWN + 1)[1:]}) if count else []


def traced(
    method: Callable[[float], FlattenableMesh], settings: Sequence[float]
) -> tuple[Trace, list[FlattenableMesh]]:
    """A run from the start for every setting, until one takes no more steps than that before."""
    trace: Trace = []
    meshes: list[FlattenableMesh] = []
    for setting in settings:
        start = time.perf_counter()
        mesh = method(setting)
        seconds = time.perf_counter() - start
        if trace and mesh.steps == trace[-1][0]:
            continue
        if seconds < SHORT:
            seconds = median_seconds(lambda setting=setting: method(setting), RUNS)
        trace.append((mesh.steps, seconds, mesh.max_flattenability))
        meshes.append(mesh)
    return trace, meshes


def plot(file: Path, traces: dict[str, Trace]) -> Path:
    figure = Figure(figsize=(10, 3.6), layout="constrained")
    for index, (axes, label) in enumerate(zip(figure.subplots(1, 2, sharey=True), ("accumulated steps", "seconds"))):
        for name, trace in traces.items():
            x, y = [point[index] for point in trace], [max(point[2], SMALLEST) for point in trace]
            axes.semilogy(x, y, marker="o", markersize=3, label=name)
        axes.set_xscale("symlog", linthresh=5 if index == 0 else 0.05)
        axes.set_xlabel(label)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
        if index == 0:
            axes.set_ylabel("worst flattenability, rad")
    figure.savefig(file, dpi=120)
    return file
