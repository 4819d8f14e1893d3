"""Write a mesh and its flat coordinates as Wavefront OBJ, exact to the last bit."""

from __future__ import annotations

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
    lines = ["# mm; vt: flat coordinates in mm"]
    lines += [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices.tolist()]
    lines += [f"vt {x:.17g} {y:.17g}" for x, y in flat.tolist()]
    lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (triangles + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
