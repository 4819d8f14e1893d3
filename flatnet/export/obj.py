"""Write and read a mesh and its flat coordinates as Wavefront OBJ, exact to the last bit."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def write_obj(path: Path, vertices: Floats, triangles: Ints, flat: Floats) -> None:
    """Write `v` (in space) and `vt` (flat) in mm with 17 significant digits, faces `f v/vt` counted from 1.

    Parameters
    ----------
    vertices : (m, 3) float, mm.
    triangles : (t, 3) int.
    flat : (m, 2) float, mm; one for each vertex.
    """
    lines = ["# mm; vt: flat coordinates in mm", *obj_lines(vertices, triangles, flat)]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def obj_lines(vertices: Floats, triangles: Ints, flat: Floats, first: int = 1) -> Iterator[str]:
    """The lines of one mesh, as `write_obj` has them; `first` is the number of its first vertex in the file."""
    yield from (f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices.tolist())
    yield from (f"vt {x:.17g} {y:.17g}" for x, y in flat.tolist())
    yield from (f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (triangles + first).tolist())


def read_obj(path: Path) -> tuple[Floats, Ints, Floats]:
    """Read what `write_obj` wrote.

    Returns
    -------
    vertices, triangles, flat : (m, 3) float, (t, 3) int, (m, 2) float; mm.

    Raises
    ------
    ValueError
        The file is no OBJ of ours: faces that are no triangles, or whose corners differ in `v` and `vt`.
    """
    rows: dict[str, list[list[str]]] = {"v": [], "vt": [], "f": []}
    for line in path.read_text(encoding="ascii").splitlines():
        kind, *fields = line.split() or [""]
        if kind in rows:
            rows[kind].append(fields)
    corners = np.array([[corner.split("/") for corner in face] for face in rows["f"]], np.int64) - 1
    vertices, flat = np.array(rows["v"], float), np.array(rows["vt"], float)
    triangles = corners[..., 0].copy() if corners.ndim == 3 else np.empty((0, 3), np.int64)
    if not len(triangles) or corners.shape[1:] != (3, 2) or (corners[..., 0] != corners[..., 1]).any():
        raise ValueError("not an OBJ of flatnet: its faces are to be triangles of corners `v/vt` with v = vt")
    if vertices.shape[1:] != (3,) or flat.shape != (len(vertices), 2):
        raise ValueError("not an OBJ of flatnet: it has not one `vt x y` for each `v x y z`")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise ValueError("not an OBJ of flatnet: a face names a vertex that is not there")
    return vertices, triangles, flat
