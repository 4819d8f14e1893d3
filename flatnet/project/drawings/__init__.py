"""Drawings: files with curves, as programs for drawing write them -> named polylines in the file's unit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from flatnet.project.drawings.csv_points import read_csv_points
from flatnet.project.drawings.dxf import read_dxf
from flatnet.project.drawings.file_curve import DrawingError, FileCurve
from flatnet.project.drawings.obj_lines import read_obj_lines
from flatnet.project.drawings.strokes import read_strokes
from flatnet.project.drawings.svg import read_svg

__all__ = ["READERS", "DrawingError", "FileCurve", "read_drawing"]

#: End of the file's name -> what reads it.
READERS: dict[str, Callable[[Path], list[FileCurve]]] = {
    ".csv": read_csv_points,
    ".dxf": read_dxf,
    ".json": read_strokes,
    ".obj": read_obj_lines,
    ".svg": read_svg,
}


def read_drawing(file: Path) -> list[FileCurve]:
    """The curves of a file, in its order.

    Raises
    ------
    DrawingError
        No such format, not readable, no curves, coordinates that are no finite numbers.
    """
    reader = READERS.get(file.suffix.lower())
    if reader is None:
        raise DrawingError(f"a drawing ends in {', '.join(READERS)}, not in {file.suffix!r}")
    try:
        curves = reader(file)
    except OSError as error:
        raise DrawingError(f"can't be read: {error.strerror or error}") from None
    if not curves:
        raise DrawingError("has no curves")
    for curve in curves:
        if len(curve.points) < 2 or not np.isfinite(curve.points).all():
            name = f"curve '{curve.name}'" if curve.name else "a curve"
            raise DrawingError(f"{name} has fewer than two points, or coordinates that are no finite numbers")
    return curves
