"""Write sewing.json, which edges belong together (docs/sewing.schema.json): no cutting format has a word for that."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatnet.export.written_build import WrittenBuild
from flatnet.geometry.polygon import arclengths
from flatnet.pattern.piece import Piece

FORMAT = "flatnet-sewing/1"


def write_sewing(path: Path, build: WrittenBuild) -> None:
    """Every seam with both its sides, vertex by vertex in the seam's own direction."""
    record = {
        "format": FORMAT,
        "units": "mm",
        "project": build.content.project,
        "size": build.content.size,
        "seams": [_seam(seam, build.pieces) for seam in build.report["seams"]],
    }
    path.write_text(json.dumps(record, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


def _seam(seam: Mapping[str, Any], pieces: Mapping[str, Piece]) -> dict[str, object]:
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
        "kind": _kind(seam["patches"]),
        "notches": notches,
        "sides": [_side(seam["curve"], side, pieces) for side in seam["sides"]],
    }


def _kind(patches: list[str]) -> str:
    """`opening`: nothing is sewn to it; `slit`: both sides are the same patch's; `seam`."""
    if len(patches) == 1:
        return "opening"
    return "slit" if patches[0] == patches[1] else "seam"


def _side(seam: str, side: Mapping[str, Any], pieces: Mapping[str, Piece]) -> dict[str, object]:
    """One side of a seam; every piece of its patch has it along the same vertices, with allowances of its own."""
    mine = {name: piece for name, piece in pieces.items() if piece.name == side["patch"]}
    along = next((arclengths(piece.sew_line[side["vertices"]]).tolist() for piece in mine.values()), None)
    return {
        "patch": side["patch"],
        "vertices": side["vertices"],
        "arclengths": along,
        "pieces": [
            {"name": name, "material": piece.material, "allowances": allowances}
            for name, piece in mine.items()
            if (allowances := _allowances(piece, seam, side["vertices"])) is not None
        ],
    }


def _allowances(piece: Piece, seam: str, vertices: list[int]) -> list[float] | None:
    """Of the edges along this side of the seam, told from the other side of a slit by its vertices."""
    for run in piece.seams:
        if run.seam.name == seam and run.vertices.tolist() == vertices:
            allowances: list[float] = piece.allowances[run.edges(len(piece.sew_line))].tolist()
            return allowances
    return None
