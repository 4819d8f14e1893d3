"""Contact sheets of fitted meshes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from flatnet.fitting.results import SurfaceMesh
from flatnet.report.panels import POINT, Panel, shaded_panel
from flatnet.report.view import Surface, cameras

#: Inches; panels are cells wide, and as high as the highest of their row, or twice as high as wide.
WIDTH, GAP = 3.0, 0.35
HIGHEST = 2.0


def mesh_sheet(file: Path, meshes: Sequence[tuple[str, SurfaceMesh]], columns: int = 6) -> Path:
    """Every mesh twice, along its mean normal and from the side, where folds show."""
    panels: list[Panel] = []
    for caption, mesh in meshes:
        surface = Surface.of([mesh])
        first, second = cameras(surface)
        panels += [shaded_panel(caption, surface, first), shaded_panel("", surface, second)]
    return panel_sheet(file, panels, columns)


def panel_sheet(file: Path, panels: Sequence[Panel], columns: int) -> Path:
    """Rows of panels, each as high as it must be."""
    rows = [panels[first : first + columns] for first in range(0, len(panels), columns)]
    heights = [max(min(WIDTH / panel.aspect, HIGHEST * WIDTH) for panel in row) + GAP for row in rows]
    figure = Figure(figsize=(columns * WIDTH, sum(heights) + GAP), facecolor="white")
    grid = figure.add_gridspec(len(rows), columns, height_ratios=heights)
    for index, panel in enumerate(panels):
        axes = figure.add_subplot(grid[index // columns, index % columns])
        axes.set_axis_off()
        axes.set_aspect("equal")
        axes.set_xlim(panel.low[0], panel.high[0])
        axes.set_ylim(panel.low[1], panel.high[1])
        axes.set_title(panel.caption, fontsize=7, loc="left")
        panel.paint(axes, WIDTH / float(panel.high[0] - panel.low[0]) / POINT)
    figure.tight_layout()
    figure.savefig(file, dpi=110)
    return file
