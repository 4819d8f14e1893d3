"""OBJ: its `l` elements, polylines through vertices."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flatnet.project.drawings.file_curve import DrawingError, FileCurve


def read_obj_lines(file: Path) -> list[FileCurve]:
    """Every `l` element, named by the last `o` or `g` before it."""
    vertices: list[list[float]] = []
    elements: list[tuple[str, int, list[int]]] = []
    name = ""
    for number, line in enumerate(file.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        kind, *fields = line.split() or [""]
        try:
            if kind == "v":
                x, y, z = (float(field) for field in fields[:3])
                vertices.append([x, y, z])
            elif kind in ("o", "g"):
                name = "_".join(fields)
            elif kind == "l":
                elements.append((name, number, [int(field.split("/")[0]) for field in fields]))
        except ValueError:
            raise DrawingError(f"line {number}: {line.strip()[:60]!r} is no vertex or line of an OBJ") from None
    points = np.array(vertices, dtype=float).reshape(-1, 3)
    curves = []
    for name, number, indices in elements:
        places = [index - 1 if index > 0 else len(points) + index for index in indices]
        if len(places) < 2 or 0 in indices or min(places) < 0 or max(places) >= len(points):
            raise DrawingError(f"line {number}: an 'l' needs two or more of the file's {len(points)} vertices")
        curves.append(FileCurve(name, points[places]))
    return curves
