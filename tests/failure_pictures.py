"""Draw a case of docs/failures.md from its builds: as it is and with the remedy, in space and flat."""

from __future__ import annotations

import io
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from PIL import Image

from flatnet.build import check
from flatnet.fitting.boundary_alone import boundary_alone
from flatnet.fitting.results import Floats
from flatnet.fitting.unfold import unfold
from flatnet.geometry.triangles import edges_of
from flatnet.report.build_files import BuildFiles, BuiltPatch, read_build
from flatnet.report.panels import Panel, distance_panel, shaded_panel
from flatnet.report.view import Camera, Surface, cameras

#: Inches of a panel, and dots per inch.
WIDTH, HEIGHT, DPI = 2.3, 1.9, 80
#: How many of a picture's colours are kept: a third of its size.
COLOURS = 48
#: Where there is no mesh to choose the direction by.
FROM_ABOVE = Camera(-65.0, 40.0)
CURVE, MESH, PIECE = "#b00020", "#c4cad6", "#1a1f33"
#: Millimetres between flat pieces.
GAP = 12.0
#: The patch beside the case, which is always made.
GOOD = "good"


def outlines(project_file: Path, names: Collection[str]) -> list[Floats]:
    """The flat outlines that the boundaries alone of patches have, whether they cover themselves or not."""
    if not names:
        return []
    _, network = check(project_file)
    return [unfold(boundary_alone(patch.boundary)) for patch in network.patches if patch.name in names]


def draw(file: Path, before: Path, after: Path, failed: Sequence[Floats]) -> None:
    """Write the PNG of two builds.

    Parameters
    ----------
    failed : (n, 2) float, mm each; `outlines` of what could not be made before.
    """
    builds = [read_build(folder) for folder in (before, after)]
    surfaces = [Surface.of([p.mesh for p in patches_of(build)]) if patches_of(build) else None for build in builds]
    camera = next((cameras(surface)[0] for surface in reversed(surfaces) if surface), FROM_ABOVE)
    figure = Figure(figsize=(4 * WIDTH, HEIGHT + 0.25), facecolor="white")
    for side, (build, title) in enumerate(zip(builds, ("as it is", "with the remedy"), strict=True)):
        space, flat = (figure.add_subplot(1, 4, 2 * side + k) for k in (1, 2))
        for axes in (space, flat):
            axes.set_axis_off()
            axes.set_aspect("equal")
        figure.text(0.5 * side + 0.01, 0.93, title, fontsize=8)
        in_space(space, build, surfaces[side], camera)
        pieces(flat, build, () if side else failed)
    figure.subplots_adjust(0.01, 0.02, 0.99, 0.9, 0.04, 0.0)
    file.parent.mkdir(parents=True, exist_ok=True)
    full = io.BytesIO()
    figure.savefig(full, dpi=DPI)
    Image.open(full).convert("RGB").quantize(COLOURS).save(file, optimize=True)


def patches_of(build: BuildFiles) -> list[BuiltPatch]:
    """Those of the case."""
    return [patch for patch in build.patches if patch.name != GOOD]


def in_space(axes: Axes, build: BuildFiles, surface: Surface | None, camera: Camera) -> None:
    """The meshes, and all curves in red, of which those of a failed patch bound nothing."""
    if surface is not None:
        panel = _panel(build, surface, camera)
        panel.paint(axes, 72.0 * WIDTH / float((panel.high - panel.low).max()))
    curves = [
        camera.project(np.array(one["vertices"]))[:, :2] for one in build.network["curves"] if one["curve"] != GOOD
    ]
    axes.add_collection(LineCollection(curves, colors=CURVE, linewidths=0.9))
    axes.autoscale_view()


def _panel(build: BuildFiles, surface: Surface, camera: Camera) -> Panel:
    heights: list[Any] = [patch.heights for patch in patches_of(build)]
    if any(one is None for one in heights):
        return shaded_panel("", surface, camera)
    corners = [one[patch.mesh.triangles] for one, patch in zip(heights, patches_of(build), strict=True)]
    return distance_panel(np.concatenate(corners), surface, camera)


def pieces(axes: Axes, build: BuildFiles, failed: Sequence[Floats]) -> None:
    """The flat pieces side by side with their meshes; in red the outlines of what failed."""
    left = 0.0
    for outline in failed:
        placed = outline - outline.min(axis=0) + [left, 0.0]
        left = float(placed[:, 0].max()) + GAP
        axes.add_collection(PolyCollection([placed], facecolors="none", edgecolors=CURVE, linewidths=0.8))
    for patch in patches_of(build):
        flat = patch.flat - patch.flat.min(axis=0) + [left, 0.0]
        left = float(flat[:, 0].max()) + GAP
        axes.add_collection(LineCollection(list(flat[edges_of(patch.mesh.triangles)]), colors=MESH, linewidths=0.3))
        outline = [flat[: patch.mesh.boundary_count]]
        axes.add_collection(PolyCollection(outline, facecolors="none", edgecolors=PIECE, linewidths=0.8))
    axes.autoscale_view()
