"""Write sewing.json, which edges belong together (docs/sewing.schema.json): no cutting format has a word for that."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from flatnet.export.seam_sides import run_on
from flatnet.export.written_build import WrittenBuild
from flatnet.geometry.polygon import arclengths
from flatnet.pattern.piece import Piece, SeamRun

FORMAT = "flatnet-sewing/1"


def write_sewing(path: Path, build: WrittenBuild) -> None:
    """Every seam with both its sides, vertex by vertex in the seam's own direction."""
    record = {
        "format": FORMAT,
        "units": "mm",
        "project": build.content.project,
        "size": build.content.size,
        "seams": [_seam(seam, build) for seam in build.report["seams"]],
    }
    path.write_text(json.dumps(record, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


def _seam(seam: Mapping[str, Any], build: WrittenBuild) -> dict[str, object]:
    notches = [
        {"arclength": notch["at_3d_mm"], "marks": notch["marks"], "sides": [notch["at_a_mm"], notch["at_b_mm"]]}
        for notch in seam["notches"]
    ]
    for notch in notches:
        notch["sides"] = notch["sides"][: len(seam["sides"])]
    return {
        "name": seam["curve"],
        "number": seam["number"],
        "from": seam["from"],
        "to": seam["to"],
        "length": seam["length_3d_mm"],
        "kind": _kind(seam, build.pieces.values()),
        "notches": notches,
        "sides": [_side(seam["curve"], side, build) for side in seam["sides"]],
    }


def _kind(seam: Mapping[str, Any], pieces: Iterable[Piece]) -> str:
    """`fold`: its piece goes on there; `opening`: one side; `slit`: both sides are the same patch's; `seam`."""
    patches = seam["patches"]
    mine = [piece for piece in pieces if piece.name in patches]
    if mine and not any(run.seam.name == seam["curve"] for piece in mine for run in piece.seams):
        return "fold"
    if len(patches) == 1:
        return "opening"
    return "slit" if patches[0] == patches[1] else "seam"


def _side(seam: str, side: Mapping[str, Any], build: WrittenBuild) -> dict[str, object]:
    """One side of a seam, and where every piece of its patch has it, with allowances of its own."""
    flat = next((mesh.flat for mesh in build.meshes if mesh.patch == side["patch"]), None)
    return {
        "patch": side["patch"],
        "vertices": side["vertices"],
        "arclengths": None if flat is None else arclengths(flat[side["vertices"]]).tolist(),
        "pieces": [
            _on_piece(name, piece, *runs)
            for name, piece in build.pieces.items()
            if piece.name == side["patch"] and (runs := run_on(piece, seam, side["vertices"]))
        ],
    }


def _on_piece(name: str, piece: Piece, run: SeamRun, image: SeamRun | None) -> dict[str, object]:
    return {
        "name": name,
        "material": piece.material,
        "vertices": run.vertices.tolist(),
        "image": None if image is None else image.vertices.tolist(),
        "allowances": piece.allowances[run.edges(len(piece.sew_line))].tolist(),
    }
