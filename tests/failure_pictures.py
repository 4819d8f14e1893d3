"""Draw the cases of docs/failures.md from real builds: as they are, and with the remedy; `make failures` does it too.

`python tests/failure_pictures.py CODE ...` draws these alone.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from failure_cases import CASES
from failure_table import PAGE, tried
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from flatnet.build import check
from flatnet.fitting.boundary_alone import boundary_alone
from flatnet.fitting.results import Floats
from flatnet.fitting.unfold import unfold
from flatnet.geometry.triangles import edges_of
from flatnet.report.build_files import BuildFiles, read_build
from flatnet.report.panels import Panel, distance_panel, shaded_panel
from flatnet.report.view import Camera, Surface, cameras

FOLDER = PAGE.parent / "pictures" / "failures"
#: Inches of a panel, and dots per inch.
WIDTH, HEIGHT, DPI = 2.3, 1.9, 80
#: Where there is no mesh to choose the direction by.
FROM_ABOVE = Camera(-65.0, 40.0)
CURVE, MESH, PIECE = "#b00020", "#c4cad6", "#1a1f33"
#: Millimetres between flat pieces.
GAP = 12.0


def draw(code: str) -> Path:
    """The case in space, its flat pieces, and both with the remedy."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        content = CASES[code].content(folder)
        for section in ("curves", "patches"):
            content[section].pop("good", None)
        row = tried(code, content, folder)
        builds = [read_build(folder / side) if (folder / side).exists() else None for side in ("before", "after")]
        failed = unmade(content, folder) if builds[0] else []
    meshes = [[patch.mesh for patch in build.patches] if build else [] for build in builds]
    surfaces = [Surface.of(of) if of else None for of in meshes]
    camera = next((cameras(surface)[0] for surface in reversed(surfaces) if surface), FROM_ABOVE)
    figure = Figure(figsize=(4 * WIDTH, HEIGHT + 0.25), facecolor="white")
    for side, build in enumerate(builds):
        title = (f"{code}: {row.detected}", f"remedy: {row.result.split(';')[0]}")[side]
        space, flat = (figure.add_subplot(1, 4, 2 * side + k) for k in (1, 2))
        for axes in (space, flat):
            axes.set_axis_off()
            axes.set_aspect("equal")
        space.set_title(title.replace("`", ""), fontsize=7, loc="left", parse_math=False)
        if build is not None:
            in_space(space, build, surfaces[side], camera)
            pieces(flat, build, failed if side == 0 else [])
    figure.subplots_adjust(0.01, 0.02, 0.99, 0.9, 0.04, 0.0)
    FOLDER.mkdir(parents=True, exist_ok=True)
    figure.savefig(FOLDER / f"{code}.png", dpi=DPI, metadata={"Software": None})
    return FOLDER / f"{code}.png"


def in_space(axes: Axes, build: BuildFiles, surface: Surface | None, camera: Camera) -> None:
    """The meshes, and all curves in red, of which those of a failed patch bound nothing."""
    if surface is not None:
        panel = _panel(build, surface, camera)
        panel.paint(axes, 72.0 * WIDTH / float((panel.high - panel.low).max()))
    curves = [camera.project(np.array(one["vertices"]))[:, :2] for one in build.network["curves"]]
    axes.add_collection(LineCollection(curves, colors=CURVE, linewidths=0.9))
    axes.autoscale_view()


def _panel(build: BuildFiles, surface: Surface, camera: Camera) -> Panel:
    heights: list[Any] = [patch.heights for patch in build.patches]
    if any(one is None for one in heights):
        return shaded_panel("", surface, camera)
    corners = [one[patch.mesh.triangles] for one, patch in zip(heights, build.patches, strict=True)]
    return distance_panel(np.concatenate(corners), surface, camera)


def unmade(content: dict[str, Any], folder: Path) -> list[Floats]:
    """The flat outlines that the boundaries alone of failed patches have, whether they cover themselves or not."""
    file = folder / "project.yaml"
    file.write_text(yaml.safe_dump(content))
    _, network = check(file)
    report = json.loads((folder / "before" / "report.json").read_text())
    failed = {patch["name"] for patch in report["patches"] if patch["failure"]}
    return [unfold(boundary_alone(patch.boundary)) for patch in network.patches if patch.name in failed]


def pieces(axes: Axes, build: BuildFiles, failed: Sequence[Floats]) -> None:
    """The flat pieces side by side with their meshes; in red the outlines of what failed."""
    left = 0.0
    for outline in failed:
        placed = outline - outline.min(axis=0) + [left, 0.0]
        left = float(placed[:, 0].max()) + GAP
        axes.add_collection(PolyCollection([placed], facecolors="none", edgecolors=CURVE, linewidths=0.8))
    for patch in build.patches:
        flat = patch.flat - patch.flat.min(axis=0) + [left, 0.0]
        left = float(flat[:, 0].max()) + GAP
        axes.add_collection(LineCollection(list(flat[edges_of(patch.mesh.triangles)]), colors=MESH, linewidths=0.3))
        outline = [flat[: patch.mesh.boundary_count]]
        axes.add_collection(PolyCollection(outline, facecolors="none", edgecolors=PIECE, linewidths=0.8))
    axes.autoscale_view()


def main(codes: Sequence[str]) -> None:
    for code in codes or CASES:
        file = draw(code)
        print(f"{file}: {file.stat().st_size / 1000:.0f} kB", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
