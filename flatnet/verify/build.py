"""A build as its files tell it: patches with their meshes, curves, seams, materials, pieces, layouts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flatnet.verify.measured import Measured, damage
from flatnet.verify.mesh import WrittenMesh, farthest
from flatnet.verify.written import REPORT, DamagedError, Record, WrittenFiles

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NETWORK = "network.json"
PIECES = "pieces.json"


class Findings(list[Measured]):
    """All that was measured; damaged files are findings too."""

    @contextmanager
    def guarded(self) -> Iterator[None]:
        """What is in a damaged file is left out, and the damage noted."""
        try:
            yield
        except DamagedError as error:
            self.append(damage(error.file, error.words))


@dataclass(frozen=True, eq=False)
class WrittenPatch:
    """A patch that was fitted.

    Attributes
    ----------
    file : its OBJ.
    metrics : what the report says of it.
    strain_limit : what its material gives; 0: exact.
    """

    name: str
    file: str
    mesh: WrittenMesh
    metrics: Record
    strain_limit: float

    def beside(self, ending: str) -> str:
        """The file of the same patch with another ending."""
        return self.file.removesuffix(".obj") + ending


@dataclass(frozen=True, eq=False)
class WrittenCurve:
    """A stretch of a curve: vertices (n, 3) mm, unit normals (n - 1, 3) of its edges on its left and its right side."""

    vertices: Floats
    left_normals: Floats
    right_normals: Floats


@dataclass(frozen=True, eq=False)
class WrittenHide:
    """Outlines, (k, 2) mm each, y up, from (0, 0); `zones` with the name of their quality."""

    outline: Floats
    defects: tuple[Floats, ...]
    zones: tuple[tuple[str, Floats], ...]

    @property
    def width(self) -> float:
        return float(self.outline[:, 1].max())


@dataclass(frozen=True, eq=False)
class WrittenMaterial:
    """What pieces are cut from; `rotations` None: free; `length` and `count` (of sheets) inf: no limit."""

    width: float
    length: float
    rotations: Floats | None
    gap: float
    strain: float
    count: float
    hides: tuple[WrittenHide, ...]


@dataclass(frozen=True, eq=False)
class WrittenPiece:
    """A piece of pieces.json.

    Attributes
    ----------
    name : that of its drawing.
    cut, mirrored : how many plain and mirrored copies.
    sew_line, cut_line, holes : closed, (k, 2) float, mm, in its own frame.
    zone, match : the zone of a hide that it asks for, or ""; whether all copies lie in one direction.
    notches : seam -> places of its notches on the sew line, (2,) each.
    lines : class of its other paths -> their lines, (k, 2) each.
    feet : where each mark of a notch, and each nick, begins: the middle of its mouth, (2,).
    drills : marks that are points, (2,) each.
    fold : (2, 2) float, mm: start and end of the line across which its patch, one half of it, is mirrored; or None.
    """

    name: str
    patch: str
    material: str
    cut: int
    mirrored: int
    sew_line: Floats
    cut_line: Floats
    holes: tuple[Floats, ...]
    notches: dict[str, list[Floats]]
    lines: dict[str, list[Floats]]
    feet: list[Floats]
    drills: list[Floats]
    fold: Floats | None
    zone: str
    match: bool

    @property
    def file(self) -> str:
        """Its drawing."""
        return f"pieces/{self.name}.svg"

    @property
    def half(self) -> Floats:
        """Of a piece with a fold, the part of its sew line that is its patch's: from the fold's end to its start."""
        return self.sew_line[: len(self.sew_line) // 2 + 1]

    def outline_of(self, mesh: WrittenMesh) -> Floats:
        """The sew line that it has by its patch's mesh: the flat boundary, with a fold also its mirror image."""
        if self.fold is None:
            return mesh.outline
        start, end = self.fold
        at = [int(np.argmin(np.linalg.norm(mesh.outline - place, axis=1))) for place in (start, end)]
        count = (at[0] - at[1]) % len(mesh.outline) + 1
        half = np.roll(mesh.outline, -at[1], axis=0)[:count]
        along = (end - start) / np.linalg.norm(end - start)
        image = start + 2.0 * ((half - start) @ along)[:, None] * along - (half - start)
        return np.concatenate([half, image[-2:0:-1]])


@dataclass(frozen=True, eq=False)
class WrittenBuild:
    """What could be read of a build; `report` is all of report.json."""

    report: Record
    patches: dict[str, WrittenPatch] = field(default_factory=dict)
    failed: set[str] = field(default_factory=set)
    curves: dict[str, WrittenCurve] = field(default_factory=dict)
    materials: dict[str, WrittenMaterial] = field(default_factory=dict)
    pieces: list[WrittenPiece] = field(default_factory=list)

    def piece(self, patch: str, material: str) -> WrittenPiece:
        """The piece of a patch from a material."""
        for piece in self.pieces:
            if (piece.patch, piece.material) == (patch, material):
                return piece
        raise DamagedError(PIECES, f"there is no piece of '{patch}' from '{material}'")


def read_build(files: WrittenFiles, report: Record, findings: Findings) -> WrittenBuild:
    """Read what the checks share; what is damaged is left out and found."""
    build = WrittenBuild(report)
    with findings.guarded():
        pieces = Record(PIECES, files.json(PIECES))
        for record in pieces.records("materials"):
            build.materials[record.text("name")] = _material(record)
        for record in pieces.records("pieces"):
            with findings.guarded():
                build.pieces.append(_piece(record))
    with findings.guarded():
        listed = set(report.texts("files"))
        for record in report.records("patches"):
            with findings.guarded():
                _read_patch(files, record, listed, build)
    with findings.guarded():
        network = Record(NETWORK, files.json(NETWORK))
        nodes = network.record("nodes")
        for record in network.records("curves"):
            with findings.guarded():
                curve = build.curves[record.text("name")] = _curve(record)
                off = _off_nodes(record, curve, nodes)
                findings.append(Measured("curves end in their nodes", NETWORK, record.text("name"), off, 0.0, "mm"))
    return build


def _material(record: Record) -> WrittenMaterial:
    hides = tuple(_hide(hide) for hide in record.records("hides")) if record.has("hides") else ()
    count = len(hides) or (record.number("sheets") if record.has("sheets") else np.inf)
    return WrittenMaterial(
        width=record.number("width"),
        length=record.number("length") if record.has("length") else np.inf,
        rotations=record.numbers("rotations") if record.has("rotations") else None,
        gap=record.number("gap"),
        strain=record.number("strain"),
        count=count,
        hides=hides,
    )


def _hide(record: Record) -> WrittenHide:
    zones = tuple((zone.text("0"), zone.numbers("1", 2)) for zone in record.pairs("zones"))
    return WrittenHide(record.numbers("outline", 2), tuple(record.point_lists("defects")), zones)


def _piece(record: Record) -> WrittenPiece:
    notches: dict[str, list[Floats]] = {}
    strokes: list[Floats] = []  # the first of each mark
    for notch in record.records("notches"):
        notches.setdefault(notch.text("seam"), []).append(notch.point("position"))
        lines, marks = notch.point_lists("lines"), notch.count("marks")
        if marks < 1 or len(lines) % marks:
            raise DamagedError(PIECES, f"a notch of '{record.text('name')}' has {len(lines)} lines for {marks} marks")
        strokes += lines[:: len(lines) // marks] if lines else []
    nicks = [nick.numbers("points", 2) for nick in record.records("nicks")] if record.has("nicks") else []
    marked = [mark.numbers("points", 2) for mark in record.records("marks")]
    piece = WrittenPiece(
        name=record.text("name"),
        patch=record.text("patch"),
        material=record.text("material"),
        cut=record.count("cut"),
        mirrored=record.count("mirrored"),
        sew_line=record.numbers("sew_line", 2),
        cut_line=record.numbers("cut_line", 2),
        holes=tuple(record.point_lists("holes")),
        notches=notches,
        lines={
            "notch": [line for notch in record.records("notches") for line in notch.point_lists("lines")],
            "nick": nicks,
            "internal": [line for mark in record.records("marks") for line in mark.point_lists("lines")],
            "grain": [record.numbers("grain", 2)] if record.has("grain") else [],
        },
        feet=[line[[0, -1 if len(line) > 2 else 0]].mean(axis=0) for line in (*strokes, *nicks)],
        drills=[points[0] for points in marked if len(points) == 1],
        fold=record.numbers("fold", 2) if record.has("fold") else None,
        zone=record.text("zone") if record.has("zone") else "",
        match=record.has("match") and record.flag("match"),
    )
    if min(map(len, (piece.sew_line, piece.cut_line, *piece.holes))) < 3 or (
        piece.fold is not None and len(piece.fold) != 2
    ):
        raise DamagedError(PIECES, f"the lines of '{piece.name}' are no outlines")
    return piece


def _read_patch(files: WrittenFiles, record: Record, listed: set[str], build: WrittenBuild) -> None:
    """A patch with a piece whose name is also that of an OBJ: that of its own material."""
    name = record.text("name")
    if record.text("status") != "ok":
        build.failed.add(name)
    for piece in build.pieces:
        file = f"patches/{piece.name}.obj"
        if piece.patch == name and file in listed:
            strain = build.materials[piece.material].strain if piece.material in build.materials else 0.0
            build.patches[name] = WrittenPatch(name, file, files.mesh(file), record.record("metrics"), strain)
            return
    if name not in build.failed:
        raise DamagedError(REPORT, f"patch '{name}' was made, and has no piece in {PIECES} or no mesh among the files")


def _off_nodes(record: Record, curve: WrittenCurve, nodes: Record) -> float:
    """How far its ends are from the nodes that it names, mm; of a closed one without nodes, from each other."""
    if not record.has("from"):
        return farthest(curve.vertices[:1], curve.vertices[-1:])
    ends = np.array([nodes.numbers(record.text(end)) for end in ("from", "to")])
    return farthest(curve.vertices[[0, -1]], ends) if ends.shape == (2, 3) else np.nan


def _curve(record: Record) -> WrittenCurve:
    vertices, left = record.numbers("vertices", 3), record.numbers("normals", 3)
    right = record.numbers("right_normals", 3) if record.has("right_normals") else left
    if len(vertices) < 2 or not len(left) == len(right) == len(vertices) - 1:
        raise DamagedError(NETWORK, f"'{record.text('name')}' has {len(vertices)} vertices and {len(left)} normals")
    return WrittenCurve(vertices, left, right)
