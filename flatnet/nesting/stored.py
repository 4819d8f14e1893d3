"""Placements kept in a file and used again where nothing that they were made from has changed.

The engine works against the clock, so the same seed need not give the same layout twice; what must repeat is
stored.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from flatnet.nesting.layout import Layout, Placement
from flatnet.parameters import NestingParameters
from flatnet.pattern.piece import Piece
from flatnet.project.model import Material

FORMAT = "flatnet-layout/2"

#: Digest -> how many seconds the engine was given, and the placements of each sheet, as in the file.
Stored = Mapping[str, Any]


def digest_of(pieces: Sequence[Piece], material: Material, parameters: NestingParameters) -> str:
    """SHA-256 of everything that a layout depends on but for the engine's time; cut lines count to 0.001 mm."""
    content = {
        "pieces": [
            [piece.name, piece.cut, piece.mirrored, piece.zone, piece.match]
            + np.rint(piece.cut_line * 1000.0).astype(int).tolist()
            for piece in pieces
        ],
        "sheet": [material.width, material.length, material.rotations, material.gap, material.sheets],
        "hides": [asdict(hide) for hide in material.hides],
        "seed": parameters.seed,
    }
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()


def read_stored(path: Path) -> Stored:
    """What an earlier build stored; nothing where the file is absent, corrupt or not ours."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        return {}
    layouts = content.get("layouts")
    return layouts if isinstance(layouts, dict) else {}


def write_stored(path: Path, layouts: Iterable[Layout]) -> None:
    """Store the placements of all layouts; drafts are left out, so that the engine is asked again."""
    stored: dict[str, dict[str, Any]] = {}
    for layout in layouts:
        if not layout.draft:
            record = stored.setdefault(layout.digest, {"seconds": layout.seconds, "sheets": []})
            record["sheets"].append([p.as_dict() for p in layout.placements])
    path.write_text(json.dumps({"format": FORMAT, "layouts": stored}, indent=1) + "\n", encoding="utf-8")


def restore(
    stored: Stored, digest: str, pieces: Sequence[Piece], material: Material, seconds: int
) -> tuple[Layout, ...] | None:
    """The layouts stored under a digest, still to be checked.

    None where there are none that can be read, or the engine was given less than these seconds for them.
    """
    by_name = {piece.name: piece for piece in pieces}
    try:
        given = int(stored[digest]["seconds"])
        if given < seconds:
            return None
        return tuple(
            Layout(material, tuple(_placement(record, by_name) for record in sheet), number, False, digest, given)
            for number, sheet in enumerate(stored[digest]["sheets"], start=1)
        )
    except (KeyError, TypeError, ValueError, OverflowError):  # a file that somebody edited
        return None


def _placement(record: Mapping[str, Any], by_name: Mapping[str, Piece]) -> Placement:
    numbers = [float(record[key]) for key in ("rotation_deg", "x_mm", "y_mm")]
    return Placement(by_name[record["patch"]], int(record["copy"]), bool(record["mirrored"]), *numbers)
