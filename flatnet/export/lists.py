"""Write the cut list and the material list as CSV."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from flatnet.export.written_build import WrittenBuild
from flatnet.geometry.polygon import side_lengths


def write_cut_list(path: Path, build: WrittenBuild) -> None:
    """A row for every piece: how many to cut of what, its size in its own frame, and the sheets that it lies on."""
    rows = []
    for name, piece in build.pieces.items():
        sheets = [sheet.name for sheet in build.sheets if any(p.piece is piece for p in sheet.layout.placements)]
        width, height = np.ptp(piece.cut_line, axis=0)
        rows.append(
            {
                "piece": name,
                "patch": piece.name,
                "material": piece.material,
                "cut": piece.cut,
                "mirrored": piece.mirrored,
                "along_grain_mm": f"{width:.1f}",
                "across_grain_mm": f"{height:.1f}",
                "area_mm2": f"{piece.area:.0f}",
                "cut_length_mm": f"{sum(side_lengths(line).sum() for line in (piece.cut_line, *piece.holes)):.1f}",
                "sheets": " ".join(sheets),
            }
        )
    _write(path, rows)


def write_material_list(path: Path, build: WrittenBuild) -> None:
    """A row for every sheet: what it is, how much of it is used, how many copies lie on it."""
    rows = [
        {
            "material": sheet.layout.material.name,
            "sheet": sheet.layout.sheet,
            "file": sheet.name,
            "width_mm": f"{sheet.layout.size[1]:g}",
            "used_length_mm": f"{sheet.layout.used_length:.1f}",
            "area_m2": f"{1e-6 * sheet.layout.area:.3f}",
            "copies": len(sheet.layout.placements),
            "used_percent": f"{100.0 * sheet.layout.utilisation:.1f}",
        }
        for sheet in build.sheets
    ]
    _write(path, rows)


def _write(path: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """With a byte-order mark, without which spreadsheets take UTF-8 for another encoding."""
    with path.open("w", encoding="utf-8-sig", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]) if rows else [])
        writer.writeheader()
        writer.writerows(rows)
