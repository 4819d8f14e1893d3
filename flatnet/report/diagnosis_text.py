"""A diagnosis in words: what is wrong, the cuts that were tried, and the best one ready to paste."""

from __future__ import annotations

import numpy as np

from flatnet.fitting.results import FailedPatch, FittedPatch
from flatnet.geometry.triangles import bending
from flatnet.project.model import Project
from flatnet.remedies.diagnose import Diagnosis, Result, Trial, is_wrinkled, needs_cut
from flatnet.remedies.paste import paste
from flatnet.remedies.ring_seam import RingSeam
from flatnet.report.warnings import wrinkled


def diagnosis_lines(project: Project, diagnosis: Diagnosis) -> list[str]:
    """What the terminal shows of one patch."""
    patch = diagnosis.patch
    lines = [f"{patch.name}: {what_is_wrong(diagnosis.result)}"]
    if not diagnosis.trials:
        return [*lines, "  no cut across it was found: every straight way leads outside."]
    lines.append(f"  {len(diagnosis.trials)} cuts were tried, the best first:")
    for i, trial in enumerate(diagnosis.trials, start=1):
        lines += [f"  {i}. {trial_line(diagnosis, trial)}", *(f"     {line}" for line in _figures(trial))]
    if diagnosis.cure is None:
        return [*lines, "  none of them helps; change the curves around the patch, or its normals."]
    step = "" if diagnosis.cured or not needs_cut(diagnosis.result) else ", a step forward and no cure: cut again"
    return [*lines, f"  the best{step}, to paste:", *paste(project, diagnosis).splitlines()]


def ring_lines(project: Project, ring: RingSeam) -> list[str]:
    """What the terminal shows of a ring that was cut open."""
    length = ring.network.stretches[ring.seam].length
    return [
        f"{ring.patch.name}: not_disk: it has two boundary loops, and no flat piece has a seamless ring of cloth.",
        f"  a seam from {ring.places[0]} to {ring.places[1]}, {length:.0f} mm: with it {_outcome(ring.result)}",
        "  to paste:",
        *paste(project, ring).splitlines(),
    ]


def trial_line(diagnosis: Diagnosis, trial: Trial) -> str:
    """From where to where, how long, and what came of both parts."""
    first, last = (diagnosis.patch.boundary.place(vertex) for vertex in (trial.cut.start, trial.cut.end))
    parts = ", ".join(f"{part.name} {_outcome(result)}" for part, result in zip(trial.parts, trial.results))
    return f"{first} to {last}, {trial.cut.length:.0f} mm: {parts}; bending {trial.bending:.1f}"


def what_is_wrong(result: Result) -> str:
    """The failure, or the warning that it wrinkles, in a sentence; that nothing is, where it was asked about."""
    if isinstance(result, FittedPatch) and not is_wrinkled(result):
        mesh = result.mesh
        return f"made, bending {bending(mesh.vertices, mesh.triangles):.1f}; {_left_of_it(result)}"
    finding = result.failure if isinstance(result, FailedPatch) else wrinkled(result)
    return f"{finding.code}: {finding.message}"


def _figures(trial: Trial) -> list[str]:
    """How the parts that were made bend and leave their normals."""
    made = [result for result in trial.results if isinstance(result, FittedPatch)]
    return [f"{result.patch.name}: {_left_of_it(result)}" for result in made]


def _left_of_it(fitted: FittedPatch) -> str:
    deviations = np.degrees(fitted.mesh.normal_deviations(fitted.patch.boundary.normals))
    return (
        f"the sheet turns to and fro by {np.degrees(fitted.mesh.wrinkles.turning):.0f} degrees, its normals are left "
        f"by {deviations.mean():.1f} degrees in the mean, {deviations.max():.0f} at the most"
    )


def _outcome(result: Result) -> str:
    if isinstance(result, FailedPatch):
        return f"fails ({result.failure.code})"
    return "wrinkles" if is_wrinkled(result) else "ok"
