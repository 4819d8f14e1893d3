"""Draw the cuts that were tried: for each its two parts, in the order of their rank."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flatnet.fitting.results import FittedPatch
from flatnet.remedies.diagnose import Diagnosis, Trial
from flatnet.report.contact_sheet import MARGIN, sheet_of
from flatnet.report.diagnosis_text import trial_line, what_is_wrong
from flatnet.report.panels import Panel, shaded_panel
from flatnet.report.view import Camera, Surface, cameras

Floats = NDArray[np.float64]

#: Colours of a cut, of an outline, and of the outline of what could not be made.
CUT, OUTLINE, UNMADE = "#0a7a3c", "#1a1f33", "#b00020"
#: How many of the cuts of a patch are drawn.
DRAWN = 3


def diagnosis_picture(project: str, diagnoses: Sequence[Diagnosis]) -> bytes:
    """Every patch with its best cut, and what came of the best few, as a PNG."""

    def add_head(figure: Figure) -> None:
        width, height = figure.get_size_inches()
        x, y = MARGIN / width, 1.0 - MARGIN / height
        figure.text(x, y, f"{project}: cuts that were tried", fontsize=17, weight="bold", va="top", parse_math=False)

    return sheet_of(lambda: [panel for d in diagnoses for panel in _panels(d)], add_head)


def _panels(diagnosis: Diagnosis) -> list[Panel]:
    """The patch as it is, then the parts of its best cuts, all seen from the same direction."""
    made = [r for trial in diagnosis.trials for r in (diagnosis.result, *trial.results) if isinstance(r, FittedPatch)]
    camera = cameras(Surface.of([made[0].mesh]))[0] if made else Camera(50.0, 40.0)
    corners = diagnosis.patch.boundary.vertices
    failed = not isinstance(diagnosis.result, FittedPatch)
    cuts = [(trial.cut.vertices, CUT) for trial in diagnosis.trials[:1]]
    whole = [] if failed else [diagnosis.result]
    caption = f"{diagnosis.patch.name}: {what_is_wrong(diagnosis.result)}"
    panels = [_panel(caption, whole, [(_closed(corners), UNMADE if failed else OUTLINE), *cuts], camera)]
    for i, trial in enumerate(diagnosis.trials[:DRAWN], start=1):
        panels.append(_trial_panel(f"{i}. {trial_line(diagnosis, trial)}", trial, camera))
    return panels


def _trial_panel(caption: str, trial: Trial, camera: Camera) -> Panel:
    made = [result for result in trial.results if isinstance(result, FittedPatch)]
    unmade = [
        (_closed(part.boundary.vertices), UNMADE)
        for part, result in zip(trial.parts, trial.results, strict=True)
        if not isinstance(result, FittedPatch)
    ]
    return _panel(caption, made, [*unmade, (trial.cut.vertices, CUT)], camera)


def _panel(caption: str, made: Sequence[object], lines: Sequence[tuple[Floats, str]], camera: Camera) -> Panel:
    """Meshes, and polylines (k, 3) in their colours on top of them."""
    meshes = [result.mesh for result in made if isinstance(result, FittedPatch)]
    seen = [camera.project(line)[:, :2] for line, _ in lines]
    ends = np.concatenate(seen)
    low, high = ends.min(axis=0), ends.max(axis=0)
    below = shaded_panel(caption, Surface.of(meshes), camera) if meshes else None
    if below is not None:
        low, high = np.minimum(low, below.low), np.maximum(high, below.high)

    def paint(axes: Axes, scale: float) -> None:
        if below is not None:
            below.paint(axes, scale)
        colours = [colour for _, colour in lines]
        axes.add_collection(LineCollection(seen, colors=colours, linewidths=1.6, capstyle="round", clip_on=False))

    panel = Panel(caption, low, high, paint)
    return replace(panel, low=low - 0.02 * (high - low), high=high + 0.02 * (high - low))


def _closed(polygon: Floats) -> Floats:
    return np.concatenate([polygon, polygon[:1]])
