"""Read what a build wrote: report, network, meshes and layouts, for whoever draws or looks at them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flatnet.export.drawn_layout import DrawnPiece, read_layout
from flatnet.export.file_names import safe_file_names
from flatnet.export.obj import read_obj
from flatnet.export.output import HEIGHTS, NETWORK, REPORT, REPORT_FORMAT, read_of_build
from flatnet.fitting.results import Floats, Ints, SurfaceMesh
from flatnet.geometry.chains import boundary_edges


class BuildFilesError(Exception):
    """A folder holds no whole build."""


@dataclass(frozen=True, eq=False)
class BuiltPatch:
    """The written meshes of one patch; `flat`, (m, 2) float, mm, belongs to `mesh`.

    heights : (m,) float, mm, of the vertices of `mesh` over the reference surface; None where there is none.
    """

    name: str
    warped: SurfaceMesh
    mesh: SurfaceMesh
    flat: Floats
    heights: Floats | None = None


@dataclass(frozen=True, eq=False)
class BuildFiles:
    """The content of a build's folder.

    Attributes
    ----------
    report, network : report.json and network.json (docs/report.md); a folder of layouts alone has no curves.
    patches : those that were fitted, in the order of the report.
    sheets : file of a layout -> its pieces.
    """

    report: dict[str, Any]
    network: dict[str, Any]
    patches: tuple[BuiltPatch, ...]
    sheets: dict[str, list[DrawnPiece]]


def read_build(folder: Path) -> BuildFiles:
    """Read the written files of a build.

    Raises
    ------
    BuildFilesError
        There is no build in the folder, or a file of it is missing or is not what a build wrote.
    """
    if not folder.is_dir():
        raise BuildFilesError(f"{folder}: is no folder; name the output folder of a build")
    if not (folder / REPORT).is_file():
        raise BuildFilesError(f"{folder}: holds no {REPORT} of a build; run `flatnet build` into it first")
    report = read_of_build(folder / REPORT, _object, BuildFilesError)
    if report.get("format") != REPORT_FORMAT:
        raise BuildFilesError(
            f"{folder / REPORT}: its format is {report.get('format')!r}, not {REPORT_FORMAT!r}; build again"
        )
    try:
        names = safe_file_names(record["name"] for record in report["patches"])
        files = set(report["files"])
        layouts = [record["file"] for record in report["layouts"]]
    except (KeyError, TypeError) as error:
        raise BuildFilesError(f"{folder / REPORT}: incomplete, {error}; build again") from None
    heights = read_of_build(folder / HEIGHTS, _object, BuildFilesError) if HEIGHTS in files else {}
    return BuildFiles(
        report=report,
        network=read_of_build(folder / NETWORK, _object, BuildFilesError) if NETWORK in files else {"curves": []},
        patches=tuple(
            _patch(folder / "patches", name, file, heights.get(name))
            for name, file in names.items()
            if f"patches/{file}.obj" in files
        ),
        sheets={file: read_of_build(folder / file, read_layout, BuildFilesError) for file in layouts},
    )


def _patch(folder: Path, name: str, file: str, heights: list[float] | None) -> BuiltPatch:
    vertices, triangles, flat = read_of_build(folder / f"{file}.obj", read_obj, BuildFilesError)
    warped, warped_triangles, _ = read_of_build(folder / f"{file}.initial.obj", read_obj, BuildFilesError)
    return BuiltPatch(
        name=name,
        warped=SurfaceMesh(warped, warped_triangles, _boundary_count(warped_triangles)),
        mesh=SurfaceMesh(vertices, triangles, _boundary_count(triangles)),
        flat=flat,
        heights=None if heights is None else np.array(heights),
    )


def _boundary_count(triangles: Ints) -> int:
    """How many vertices lie on edges of one triangle only: n, as the boundary's vertices stand first."""
    return len(np.unique(boundary_edges(triangles)))


def _object(path: Path) -> dict[str, Any]:
    content = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict):
        raise ValueError("it holds no object")
    return content
