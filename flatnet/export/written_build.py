"""A build's folder as exporters take it: its pieces, sheets, seams and meshes, from the written files alone."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatnet.export.file_names import safe_file_names
from flatnet.export.obj import read_obj
from flatnet.export.output import CERTIFICATE, NETWORK, REPORT, REPORT_FORMAT, read_of_build
from flatnet.export.pieces_json import PIECES, PieceFile, read_pieces
from flatnet.geometry.chains import boundary_edges
from flatnet.nesting.layout import Layout, Placement
from flatnet.pattern.piece import Piece

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class ExportError(Exception):
    """There is nothing that can be exported, or something needed for it is missing."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """A laid-out sheet; `name` is that of its drawing, without ending."""

    name: str
    layout: Layout


@dataclass(frozen=True, eq=False)
class FittedMesh:
    """The mesh of one patch: vertices (m, 3) and flat coordinates (m, 2), mm; triangles (t, 3)."""

    patch: str
    vertices: Floats
    triangles: Ints
    flat: Floats

    @property
    def outline(self) -> Floats:
        """Its flat boundary, (n, 2): the first n vertices. Of a piece with a fold it is the one half."""
        return self.flat[: len(np.unique(boundary_edges(self.triangles)))]


@dataclass(frozen=True, eq=False)
class WrittenBuild:
    """What a build wrote.

    Attributes
    ----------
    report : the content of report.json (docs/report.md).
    content : that of pieces.json.
    sheets : in the order of the report.
    certificate : the content of certificate.json, where it is asked for.
    """

    folder: Path
    report: Mapping[str, Any]
    content: PieceFile
    sheets: tuple[Sheet, ...]
    certificate: Mapping[str, Any] | None = None

    @property
    def pieces(self) -> Mapping[str, Piece]:
        """Every piece by its name, which is also that of its file."""
        return self.content.pieces

    @property
    def missing(self) -> tuple[str, ...]:
        """The patches that were not made or not laid out."""
        if self.is_layout:
            return tuple(dict.fromkeys(found["patch"] for found in self.report["findings"] if found["patch"]))
        return tuple(record["name"] for record in self.report["patches"] if record["status"] != "ok")

    @property
    def is_layout(self) -> bool:
        """Whether it is what `flatnet nest` wrote: pieces and sheets without meshes."""
        return _is_layout(self.report)

    @cached_property
    def meshes(self) -> tuple[FittedMesh, ...]:
        """The fitted mesh of every patch that has one, in the order of the report."""
        names = safe_file_names(record["name"] for record in self.report["patches"])
        files = {name: f"patches/{file}.obj" for name, file in names.items()}
        listed = set(self.report["files"])
        return tuple(
            FittedMesh(name, *read_of_build(self.folder / file, read_obj, ExportError))
            for name, file in files.items()
            if file in listed
        )


def read_written(folder: Path, certificate: bool = False) -> WrittenBuild:
    """Read the folder of a build, and its certificate where that is asked for.

    Raises
    ------
    ExportError
        There is no build in the folder, or a file of it is missing or is not what a build wrote, or has changed since
        the certificate was made.
    """
    if not (folder / REPORT).is_file():
        raise ExportError(f"{folder}: holds no {REPORT} of a build; run `flatnet build` into it first")
    report = read_of_build(folder / REPORT, _json, ExportError)
    if not isinstance(report, dict) or report.get("format") != REPORT_FORMAT:
        raise ExportError(f"{folder / REPORT}: not a report of this version; build again")
    if _is_layout(report) and PIECES not in report["files"]:
        raise ExportError(f"{folder}: is a layout of an earlier version, without {PIECES}; run `flatnet nest` again")
    content = read_of_build(folder / PIECES, read_pieces, ExportError)
    try:
        sheets = tuple(_sheets(report["layouts"], content))
    except (KeyError, TypeError, ValueError) as error:
        raise ExportError(f"{folder / REPORT}: does not fit {PIECES}, {error}; build again") from None
    return WrittenBuild(folder, report, content, sheets, _certificate(folder / CERTIFICATE) if certificate else None)


def _is_layout(report: Mapping[str, Any]) -> bool:
    return not report.get("patches") and NETWORK not in report.get("files", ())


def _certificate(path: Path) -> Mapping[str, Any]:
    if not path.is_file():
        raise ExportError(f"{path}: is not there; run `flatnet verify {path.parent}` first")
    content: Mapping[str, Any] = read_of_build(path, _json, ExportError)
    try:
        changed = [name for name, digest in content["sha256"].items() if _digest(path.parent / name) != digest]
    except (AttributeError, KeyError, TypeError):
        raise ExportError(f"{path}: no certificate of this version; run `flatnet verify {path.parent}` again") from None
    if REPORT not in content["sha256"] or changed:
        which = ", ".join(changed[:3]) + (f" and {len(changed) - 3} more" if len(changed) > 3 else "")
        raise ExportError(
            f"{path}: speaks of other files than those that are here ({which or REPORT} changed since); run "
            f"`flatnet verify {path.parent}` again"
        )
    return content


def _digest(path: Path) -> str:
    """SHA-256; "" where there is no such file."""
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _sheets(records: Sequence[Mapping[str, Any]], content: PieceFile) -> list[Sheet]:
    pieces = {(piece.name, piece.material): piece for piece in content.pieces.values()}
    sheets: list[Sheet] = []
    for record in records:
        material = content.materials[record["material"]]
        placements = tuple(_placement(pieces[p["patch"], material.name], p) for p in record["pieces"])
        # A hide that took no piece has no record, so their numbers may have gaps.
        if material.hides and not 1 <= record["sheet"] <= len(material.hides):
            raise ValueError(f"{material.name} has {len(material.hides)} hides and none {record['sheet']}")
        layout = Layout(material, placements, record["sheet"], record["draft"])
        sheets.append(Sheet(Path(record["file"]).stem, layout))
    return sheets


def _placement(piece: Piece, record: Mapping[str, Any]) -> Placement:
    turned = record["rotation_deg"], record["x_mm"], record["y_mm"]
    return Placement(piece, record["copy"], record["mirrored"], *turned)
