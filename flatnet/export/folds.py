"""Write the dihedral angles of a fitted mesh: with the flat piece they are all that it takes to fold it again."""

from __future__ import annotations

import json
from pathlib import Path

from flatnet.fitting.results import SurfaceMesh
from flatnet.geometry.triangles import hinge_angles, hinges_of


def write_folds(path: Path, mesh: SurfaceMesh) -> None:
    """Every interior edge, from the lower to the higher vertex (from 0), and its angle in rad, to the last bit.

    0 is flat, positive convex as seen from the side that the normals point to.
    """
    hinges = hinges_of(mesh.triangles)
    content = {
        "format": "flatnet-folds/1",
        "units": "rad",
        "edges": hinges[:, :2].tolist(),
        "angles": hinge_angles(mesh.vertices, hinges).tolist(),
    }
    path.write_text(json.dumps(content) + "\n", encoding="utf-8")
