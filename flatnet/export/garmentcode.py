"""Write the pattern as GarmentCode's JSON, so that its simulator can drape it.

The format of its `*_specification.json`: panels in cm with their vertices, straight edges and place in space, and
stitches between single edges. Every edge of a sew line is an edge of its panel, so the two sides of a seam are equal
edge by edge.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flatnet.export.seam_sides import run_on
from flatnet.export.written_build import FittedMesh, WrittenBuild
from flatnet.pattern.piece import Piece

Floats = NDArray[np.float64]

CM = 0.1  # in a mm
#: To its axes, x to the wearer's left, y up, z to the front: from x to the right, y to the front, z up.
TO_ITS_AXES = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])


def write_garmentcode(path: Path, build: WrittenBuild) -> None:
    """One panel for each patch: once, of its first material, whole where it is cut on the fold."""
    meshes = {mesh.patch: mesh for mesh in build.meshes}
    pieces: dict[str, Piece] = {}
    for piece in build.pieces.values():
        pieces.setdefault(piece.name, piece)
    record = {
        "pattern": {
            "panels": {name: _panel(piece.sew_line, meshes[name]) for name, piece in pieces.items()},
            "stitches": [
                stitch
                for seam in build.report["seams"]
                if len(seam["sides"]) == 2 and all(side["patch"] in pieces for side in seam["sides"])
                for stitch in _stitches(seam["curve"], seam["sides"], pieces)
            ],
            "panel_order": list(pieces),
        },
        "parameters": {},
        "parameter_order": [],
        "properties": {
            "curvature_coords": "relative",
            "normalize_panel_translation": False,
            "normalized_edge_loops": True,
            "units_in_meter": 100,
        },
    }
    path.write_text(json.dumps(record, ensure_ascii=False) + "\n", encoding="utf-8")


def _panel(outline: Floats, mesh: FittedMesh) -> dict[str, object]:
    """The outline in its own frame, and where it lies nearest to its patch: rotation by Euler angles about x, y, z
    of space in turn, degrees."""
    rotation, shift = _nearest_place(mesh)
    count = len(outline)
    return {
        "translation": (CM * TO_ITS_AXES @ shift).tolist(),
        "rotation": _euler_angles(TO_ITS_AXES @ rotation),
        "vertices": (CM * outline).tolist(),
        "edges": [{"endpoints": [i, (i + 1) % count]} for i in range(count)],
    }


def _euler_angles(rotation: Floats) -> list[float]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # where there are several (gimbal lock), each says the same rotation
        angles: list[float] = Rotation.from_matrix(rotation).as_euler("xyz", degrees=True).tolist()
    return angles


def _nearest_place(mesh: FittedMesh) -> tuple[Floats, Floats]:
    """The rigid motion of the flat piece with the least squared distance from the fitted mesh (Kabsch)."""
    flat = np.column_stack([mesh.flat, np.zeros(len(mesh.flat))])
    middle, centre = flat.mean(axis=0), mesh.vertices.mean(axis=0)
    u, _, v = np.linalg.svd((flat - middle).T @ (mesh.vertices - centre))
    flip = np.diag([1.0, 1.0, np.linalg.det(u @ v)])
    rotation: Floats = (u @ flip @ v).T
    return rotation, centre - rotation @ middle


def _stitches(
    seam: str, sides: Sequence[Mapping[str, Any]], pieces: Mapping[str, Piece]
) -> list[list[dict[str, object]]]:
    """Edge by edge along a seam; an edge is known by the vertex that it starts from, anticlockwise."""
    names = [side["patch"] for side in sides]
    edges = []
    for name, side in zip(names, sides, strict=True):
        found = run_on(pieces[name], seam, side["vertices"])
        assert found is not None, "a fold has one side"
        edges.append(found[0].edges(len(pieces[name].sew_line)).tolist())
    return [[{"panel": name, "edge": edge} for name, edge in zip(names, pair)] for pair in zip(*edges, strict=True)]
