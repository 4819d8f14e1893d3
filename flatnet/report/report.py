"""Everything a build has to say, for programs: report.json (docs/report.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from flatnet.export.output import REPORT_FORMAT
from flatnet.failure import Finding
from flatnet.fitting.results import FailedPatch, FittedPatch
from flatnet.nesting.layout import Layout
from flatnet.network.network import CurveNetwork
from flatnet.pattern.seams import Seam
from flatnet.report.metrics import metrics
from flatnet.report.seam_walk import walk_records
from flatnet.report.seams import seam_records
from flatnet.report.warnings import patch_warnings
from flatnet.version import VERSION

Floats = NDArray[np.float64]


def make_report(
    project: str,
    network: CurveNetwork,
    seams: Mapping[str, Seam],
    heights: Mapping[str, Floats],
    clearance: float,
    results: Sequence[FittedPatch | FailedPatch],
    layouts: Mapping[str, Layout],
    findings: Sequence[Finding],
    files: Sequence[str],
) -> dict[str, object]:
    """The content of report.json.

    Parameters
    ----------
    heights : fitted patch -> those of its vertices over the reference surface, (m,) mm; empty where there is none.
    clearance : how far below it vertices may lie, mm.
    layouts : file -> the layout drawn in it.
    findings : of nesting; those that name a patch say that it was made and could not be laid.
    files : all files of the build, relative to the output folder.
    """
    fitted = {result.patch.name: result for result in results if isinstance(result, FittedPatch)}
    patches = [
        _fitted_record(result, heights, clearance, findings)
        if isinstance(result, FittedPatch)
        else _failed_record(result)
        for result in results
    ]
    return {
        "format": REPORT_FORMAT,
        "flatnet": VERSION,
        "project": project,
        "status": status([record["status"] == "ok" for record in patches], bool(layouts)),
        "patches": patches,
        "seams": seam_records(network, seams, fitted),
        "seam_walk": walk_records(network, seams, fitted),
        "layouts": [layout_record(file, layout) for file, layout in layouts.items()],
        "findings": [finding.as_dict() for finding in findings],
        "openings": {name: [list(loop) for loop in loops] for name, loops in network.openings.items()},
        "euler_characteristics": list(network.euler_characteristics),
        "files": list(files),
    }


def status(made: Sequence[bool], laid_out: bool) -> str:
    """`ok`: all patches made and laid out; `failed`: none, or no layout; else `partial`."""
    if not laid_out or not any(made):
        return "failed"
    return "ok" if all(made) else "partial"


def _fitted_record(
    fitted: FittedPatch, heights: Mapping[str, Floats], clearance: float, findings: Sequence[Finding]
) -> dict[str, object]:
    mesh = fitted.mesh
    name = fitted.patch.name
    own = heights.get(name)
    of_original = heights.get(fitted.patch.mirror_of or name)
    not_laid = next((finding for finding in findings if finding.patch == name), None)
    return {
        "name": name,
        "status": "failed" if not_laid else "ok",
        "failure": not_laid.as_dict() if not_laid else None,
        "warnings": [
            warning.on(name).as_dict()
            for warning in (*fitted.warnings, *patch_warnings(fitted, own, clearance, of_original))
        ],
        "metrics": metrics(fitted, own),
        "method": {
            "name": mesh.method,
            "parameters": dict(mesh.parameters),
            "status": mesh.status,
            "steps": mesh.steps,
        },
        "seconds": dict(fitted.seconds),
    }


def _failed_record(failed: FailedPatch) -> dict[str, object]:
    return {
        "name": failed.name,
        "status": "failed",
        "failure": failed.failure.as_dict(),
        "warnings": [warning.on(failed.name).as_dict() for warning in failed.warnings],
        "metrics": None,
        "method": None,
        "seconds": dict(failed.seconds or {}),
    }


def layout_record(file: str, layout: Layout) -> dict[str, object]:
    """A sheet as report.json has it."""
    return {
        "file": file,
        "material": layout.material.name,
        "sheet": layout.sheet,
        "sheet_width_mm": layout.size[1],
        "used_length_mm": layout.used_length,
        "utilisation": layout.utilisation,
        "draft": layout.draft,
        "hide": None if layout.hide is None else asdict(layout.hide),
        "pieces": [placement.as_dict() for placement in layout.placements],
    }
