"""Write pieces.json, every piece in its own frame in mm with full precision, and read it back (docs/pieces.md)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.polygon import arclengths
from flatnet.parameters import STROKES
from flatnet.pattern.edging import Fold
from flatnet.pattern.labels import Label
from flatnet.pattern.marks import Mark
from flatnet.pattern.nicks import Nick
from flatnet.pattern.notches import Notch
from flatnet.pattern.piece import Piece, SeamRun
from flatnet.pattern.seams import Seam
from flatnet.project.hides import Hide, Ring
from flatnet.project.model import Material
from flatnet.project.seam_specs import SeamSpec

Floats = NDArray[np.float64]

PIECES = "pieces.json"
FORMAT = "flatnet-pieces/1"


@dataclass(frozen=True, eq=False)
class PieceFile:
    """The content of pieces.json.

    Attributes
    ----------
    project, size : as the project file says them; a size may be "".
    materials : the rolls, by name.
    pieces : name of a piece, which is its file's without ending -> the piece. Its seams are known by name, number,
        curve, patches and length only.
    strokes : meaning of a line -> the colour that it is drawn in, #rrggbb.
    """

    project: str
    size: str
    materials: Mapping[str, Material]
    pieces: Mapping[str, Piece]
    strokes: Mapping[str, str] = field(default_factory=lambda: dict(STROKES))

    @property
    def title(self) -> str:
        """Name and size, as printed on pieces and layouts."""
        return f"{self.project} · {self.size}" if self.size else self.project


def write_pieces(path: Path, content: PieceFile) -> None:
    """Write every piece; numbers have as many digits as tell them from their neighbours."""
    seams = {run.seam.name: run.seam for piece in content.pieces.values() for run in piece.seams}
    record = {
        "format": FORMAT,
        "units": "mm",
        "project": content.project,
        "size": content.size,
        "strokes": dict(content.strokes),
        "materials": [_material(material) for material in content.materials.values()],
        "seams": [_seam(seam) for seam in sorted(seams.values(), key=lambda seam: seam.number)],
        "pieces": [_piece(name, piece) for name, piece in content.pieces.items()],
    }
    path.write_text(json.dumps(record, ensure_ascii=False) + "\n", encoding="utf-8")


def _material(material: Material) -> dict[str, object]:
    return {
        "name": material.name,
        "width": material.width,
        "length": material.length,
        "rotations": material.rotations,
        "gap": material.gap,
        "allowance": material.allowance,
        "strain": material.strain,
        "thickness": material.thickness,
        "sheets": material.sheets,
        "hides": [asdict(hide) for hide in material.hides],
    }


def _seam(seam: Seam) -> dict[str, object]:
    return {
        "name": seam.name,
        "number": seam.number,
        "curve": seam.curve,
        "patches": seam.patches,
        "length": seam.length,
        "sewn_to": seam.partners,
    }


def _piece(name: str, piece: Piece) -> dict[str, object]:
    return {
        "name": name,
        "patch": piece.name,
        "material": piece.material,
        "project": piece.project,
        "cut": piece.cut,
        "mirrored": piece.mirrored,
        "sew_line": piece.sew_line.tolist(),
        "cut_line": piece.cut_line.tolist(),
        "holes": [hole.tolist() for hole in piece.holes],
        "grain": None if piece.grain is None else piece.grain.tolist(),
        "one_way": piece.one_way,
        "notches": [_notch(notch) for notch in piece.notches],
        "nicks": [{"seam": nick.seam, "points": nick.points.tolist()} for nick in piece.nicks],
        "fold": None if piece.fold is None else piece.fold.line.tolist(),
        "marks": [_mark(mark) for mark in piece.marks],
        "label": _label(piece.label),
        "seams": [_run(piece, run) for run in piece.seams],
        "zone": piece.zone,
        "match": piece.match,
    }


def _notch(notch: Notch) -> dict[str, object]:
    return {
        "seam": notch.seam,
        "kind": notch.kind,
        "position": notch.position.tolist(),
        "foot": notch.foot.tolist(),
        "direction": notch.inward.tolist(),
        "depth": notch.depth,
        "width": notch.width,
        "marks": notch.marks,
        "lines": [line.tolist() for line in notch.lines],
    }


def _mark(mark: Mark) -> dict[str, object]:
    return {
        "name": mark.name,
        "kind": mark.kind,
        "points": mark.points.tolist(),
        "diameter": mark.diameter,
        "lines": [line.tolist() for line in mark.lines],
    }


def _label(label: Label) -> dict[str, object]:
    return {
        "lines": label.lines,
        "position": label.position.tolist(),
        "direction": label.direction.tolist(),
        "height": label.height,
    }


def _run(piece: Piece, run: SeamRun) -> dict[str, object]:
    return {
        "name": run.seam.name,
        "number": run.seam.number,
        "vertices": run.vertices.tolist(),
        "arclengths": arclengths(piece.sew_line[run.vertices]).tolist(),
        "allowances": piece.allowances[run.edges(len(piece.sew_line))].tolist(),
        "label": None if run.label is None else _label(run.label),
    }


def read_pieces(path: Path) -> PieceFile:
    """Read what `write_pieces` wrote.

    Raises
    ------
    ValueError
        The file is none of ours.
    """
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        if record["format"] != FORMAT:
            raise ValueError(f"its format is {record['format']!r}, not {FORMAT!r}")
        seams = {
            seam["name"]: Seam(
                seam["name"],
                seam["number"],
                seam["curve"],
                SeamSpec(),
                tuple(seam["patches"]),
                seam["length"],
                partners=tuple(seam["sewn_to"]),
            )
            for seam in record["seams"]
        }
        return PieceFile(
            project=record["project"],
            size=record["size"],
            materials={item["name"]: _read_material(item) for item in record["materials"]},
            pieces={item["name"]: _read_piece(item, seams) for item in record["pieces"]},
            strokes=STROKES | record["strokes"],
        )
    except (AttributeError, IndexError, KeyError, TypeError) as error:
        raise ValueError(f"not the pieces of a build: {type(error).__name__}: {error}") from None


def _read_material(record: Mapping[str, Any]) -> Material:
    rotations = record["rotations"]
    hides = tuple(
        Hide(
            _read_ring(hide["outline"]),
            tuple(_read_ring(defect) for defect in hide["defects"]),
            tuple((name, _read_ring(zone)) for name, zone in hide["zones"]),
        )
        for hide in record["hides"]
    )
    return Material(**{**record, "rotations": None if rotations is None else tuple(rotations), "hides": hides})


def _read_ring(points: Sequence[Sequence[float]]) -> Ring:
    return tuple((float(x), float(y)) for x, y in points)


def _read_piece(record: Mapping[str, Any], seams: Mapping[str, Seam]) -> Piece:
    sew_line = np.array(record["sew_line"], float)
    allowances = np.zeros(len(sew_line))
    runs = []
    for run in record["seams"]:
        label = None if run["label"] is None else _read_label(run["label"])
        runs.append(SeamRun(seams[run["name"]], np.array(run["vertices"], np.int64), label))
        allowances[runs[-1].edges(len(sew_line))] = run["allowances"]
    return Piece(
        name=record["patch"],
        sew_line=sew_line,
        cut_line=np.array(record["cut_line"], float),
        holes=tuple(np.array(hole, float) for hole in record["holes"]),
        allowances=allowances,
        seams=tuple(runs),
        notches=tuple(_read_notch(notch) for notch in record["notches"]),
        marks=tuple(
            Mark(mark["name"], mark["kind"], np.array(mark["points"], float), mark["diameter"])
            for mark in record["marks"]
        ),
        grain=None if record["grain"] is None else np.array(record["grain"], float),
        one_way=record["one_way"],
        label=_read_label(record["label"]),
        cut=record["cut"],
        mirrored=record["mirrored"],
        material=record["material"],
        project=record["project"],
        nicks=tuple(Nick(nick["seam"], np.array(nick["points"], float)) for nick in record["nicks"]),
        fold=None if record["fold"] is None else Fold(*np.array(record["fold"], float)),
        zone=record["zone"],
        match=record["match"],
    )


def _read_notch(record: Mapping[str, Any]) -> Notch:
    return Notch(
        seam=record["seam"],
        position=np.array(record["position"], float),
        foot=np.array(record["foot"], float),
        inward=np.array(record["direction"], float),
        kind=record["kind"],
        depth=record["depth"],
        marks=record["marks"],
    )


def _read_label(record: Mapping[str, Any]) -> Label:
    position, direction = (np.array(record[key], float) for key in ("position", "direction"))
    return Label(tuple(record["lines"]), position, direction, record["height"])
