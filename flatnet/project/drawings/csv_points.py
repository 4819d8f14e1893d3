"""CSV: a point a line, x, y, z; curves told apart by a column `curve` where there is one."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from flatnet.project.drawings.file_curve import DrawingError, FileCurve

_COLUMNS = ["x", "y", "z"]


def read_csv_points(file: Path) -> list[FileCurve]:
    """Points in columns x, y, z, or as the first line names them; `curve` names the curve of a point.

    Columns are parted by comma, semicolon or tab. Lines that are empty or begin with `#` are passed over.
    """
    text = file.read_text(encoding="utf-8-sig", errors="replace")
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not lines:
        return []
    delimiter = next((mark for mark in ";\t" if mark in lines[0][1]), ",")
    rows = [(i, [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]) for i, line in lines]
    header = [cell.lower() for cell in rows[0][1]]
    if set(_COLUMNS) <= set(header):
        rows = rows[1:]
    elif _numbers(rows[0][1]) is None:
        raise DrawingError(f"line {rows[0][0]}: expected the columns x, y, z (and curve), got {', '.join(header)}")
    else:
        header = _COLUMNS
    points: dict[str, list[list[float]]] = {}
    for number, row in rows:
        cells = dict(zip(header, row, strict=False))
        place = _numbers([cells.get(column, "") for column in _COLUMNS])
        if place is None:
            raise DrawingError(f"line {number}: expected numbers x, y, z, got {', '.join(row)}")
        points.setdefault(cells.get("curve", file.stem), []).append(place)
    return [FileCurve(name, np.array(places)) for name, places in points.items()]


def _numbers(cells: list[str]) -> list[float] | None:
    try:
        return [float(cell) for cell in cells] if len(cells) == len(_COLUMNS) else None
    except ValueError:
        return None
