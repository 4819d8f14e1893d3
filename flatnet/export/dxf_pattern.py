"""Write the pieces in the dialects of DXF that the clothing trade reads: ASTM D6673 and its forerunner AAMA-DXF.

DXF R12 in 7-bit letters, mm, one block for each piece; the layers are numbers with fixed meanings. By ezdxf, written
by its add-on for readers that stop at any block that is no piece.
"""

from __future__ import annotations

import io
import logging
import math
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.export.file_names import safe_file_names
from flatnet.export.lines import piece_labels, upright
from flatnet.export.missing_library import needs
from flatnet.export.pieces_json import PieceFile
from flatnet.export.seven_bit import Transliterated
from flatnet.pattern.labels import text_width
from flatnet.pattern.marks import Mark
from flatnet.pattern.nicks import Nick
from flatnet.pattern.notches import Notch
from flatnet.pattern.piece import Piece
from flatnet.version import VERSION

Floats = NDArray[np.float64]

CUT, TURNS, CURVES, NOTCHES, GRAIN, INTERNAL, CUTOUTS, DRILLS, SEW, WORDS = 1, 2, 3, 4, 7, 8, 11, 13, 14, 15
#: The same line once more, vouched for as accurate (ASTM only).
QUALITY = {CUT: 84, INTERNAL: 85, CUTOUTS: 86, SEW: 87}
#: Kinds of notches with a layer of their own (ASTM only); the others are on `NOTCHES`.
NOTCH_LAYERS = {"T": 80, "castle": 81}
#: A vertex where the outline turns by more than this is a turn point, rad.
LEAST_TURN = math.radians(15.0)
TEXT_HEIGHT = 5.0  # mm
#: Curve tolerance, mm: lines are polylines, every vertex of which is exact.
TOLERANCE = "0.001"


@dataclass(frozen=True)
class Dialect:
    """ASTM has layers beyond 14 and says both hands of a quantity; AAMA has other words for the file as a whole."""

    name: str
    astm: bool


ASTM, AAMA = Dialect("ASTM", True), Dialect("AAMA", False)


def write_dxf_pattern(path: Path, content: PieceFile, dialect: Dialect) -> list[str]:
    """Write one block for every piece.

    Returns
    -------
    notes : what had to be transliterated.
    """
    ezdxf = needs("ezdxf", f"DXF-{dialect.name}")
    addon = needs("ezdxf.addons.gerber_D6673", f"DXF-{dialect.name}")
    plain = Transliterated()
    with _quiet():  # R12 can't say its units; `Units: METRIC` does
        document = ezdxf.new("R12")
    page = document.modelspace()
    size = plain(content.size) or "ONE"
    _write_texts(page, _style(content, dialect, plain, size))
    titles = [plain(title) for title in _titles(content)]
    # Names that differ in their accents only are the same now: blanks keep them apart until they are numbered.
    unique = [f"{title}_{size}{' ' * titles[:number].count(title)}" for number, title in enumerate(titles)]
    names = safe_file_names(unique)
    for title, long_name, piece in zip(titles, unique, content.pieces.values(), strict=True):
        block = document.blocks.new(names[long_name])
        block.block.dxf.flags = 64
        block.block.dxf.layer = str(CUT)
        _Block(block, dialect, plain).draw(piece, title, size)
        page.add_blockref(block.name, (0.0, 0.0), dxfattribs={"layer": str(CUT)})
    text = io.StringIO()
    addon.export_stream(document, text)
    path.write_text(text.getvalue(), encoding="ascii")
    return plain.notes(path.name)


def _titles(content: PieceFile) -> list[str]:
    """Of every piece: its patch's name, of one that is cut from a further material with that."""
    patches = [piece.name for piece in content.pieces.values()]
    return [
        patch if patch not in patches[:number] else f"{patch} {piece.material}"
        for number, (patch, piece) in enumerate(zip(patches, content.pieces.values(), strict=True))
    ]


@contextmanager
def _quiet() -> Iterator[None]:
    logger = logging.getLogger("ezdxf")
    before, logger.disabled = logger.disabled, True
    try:
        yield
    finally:
        logger.disabled = before


def _style(content: PieceFile, dialect: Dialect, plain: Transliterated, size: str) -> dict[str, str]:
    """The texts that hold for the whole file."""
    # SOURCE_DATE_EPOCH is what reproducible builds set in place of the clock.
    now = time.gmtime(float(os.environ.get("SOURCE_DATE_EPOCH", time.time())))
    common = {
        "Style Name": plain(content.project),
        "Creation Date": time.strftime("%d-%m-%Y", now),
        "Creation Time": time.strftime("%H:%M", now),
        "Author": f"flatnet {VERSION}",
        "Sample Size": size,
        "Units": "METRIC",
    }
    if dialect.astm:
        return {"ASTM/D13Proposal 1 Version": "D 6673-04", **common, "Curve Tolerance": TOLERANCE}
    return {"PRODUCT": "flatnet", "VERSION": "ANSI/AAMA-292-1993", **common, "TOLERANCE": TOLERANCE}


def _write_texts(page: Any, texts: Mapping[str, str]) -> None:
    """`Key: Value`, one below the other."""
    for number, (key, value) in enumerate(texts.items()):
        place = (0.0, -1.5 * TEXT_HEIGHT * number)
        page.add_text(f"{key}: {value}", height=TEXT_HEIGHT, dxfattribs={"layer": str(CUT), "insert": place})


class _Block:
    """The block of one piece, being drawn."""

    def __init__(self, block: Any, dialect: Dialect, plain: Transliterated) -> None:
        self.block, self.dialect, self.plain = block, dialect, plain

    def draw(self, piece: Piece, name: str, size: str) -> None:
        self._texts(piece, name, size)
        self._outline(CUT, piece.cut_line)
        self._outline(SEW, piece.sew_line)
        for hole in piece.holes:
            self._outline(CUTOUTS, hole)
        ring = shapely.MultiLineString([[*line, line[0]] for line in (piece.cut_line, *piece.holes)])
        for notch in piece.notches:
            self._notch(notch, ring)
        for nick in piece.nicks:
            self._nick(nick)
        for mark in piece.marks:
            self._mark(mark)
        self._line(GRAIN, _grain(piece))

    def _texts(self, piece: Piece, name: str, size: str) -> None:
        hands = f"{piece.cut},{piece.mirrored}" if self.dialect.astm else f"{piece.cut + piece.mirrored}"
        texts = {
            "Piece Name": name,
            "Size": size,
            "Quantity": hands,
            "Annotation": " / ".join(map(self.plain, piece.description)),
            "Category": self.plain(piece.name),
            "Material": self.plain(piece.material),
        }
        start = piece.label.position
        for number, (key, value) in enumerate(texts.items()):
            self._text(CUT, f"{key}: {value}", start - (0.0, 1.5 * TEXT_HEIGHT * number), TEXT_HEIGHT, 0.0)
        if self.dialect.astm:
            for label in piece_labels(piece):
                for words in upright(label, label.direction, label.position):
                    # A text of these dialects begins at its place, which has to be the middle of these.
                    along = np.array([math.cos(words.angle), math.sin(words.angle)])
                    start = words.position - 0.5 * words.height * text_width(words.text) * along
                    self._text(WORDS, words.text, start, words.height, words.angle)

    def _text(self, layer: int, text: str, place: Floats, height: float, angle: float) -> None:
        attributes = {"layer": str(layer), "insert": tuple(place.tolist()), "rotation": math.degrees(angle)}
        self.block.add_text(self.plain(text), height=height, dxfattribs=attributes)

    def _outline(self, layer: int, points: Floats) -> None:
        """A closed line, its vertices marked as turn or curve points."""
        self._polyline(layer, points, closed=True)
        along = np.roll(points, -1, axis=0) - points
        before = np.roll(along, 1, axis=0)
        turn = np.arctan2(before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0], np.sum(before * along, axis=1))
        for point, sharp in zip(points, np.abs(turn) > LEAST_TURN, strict=True):
            self._point(TURNS if sharp else CURVES, point)

    def _polyline(self, layer: int, points: Floats, closed: bool) -> None:
        """In ASTM once more as its own quality curve."""
        for each in [layer, QUALITY[layer]] if self.dialect.astm else [layer]:
            self.block.add_polyline2d(points.tolist(), close=closed, dxfattribs={"layer": str(each)})

    def _line(self, layer: int, ends: Floats) -> None:
        self.block.add_line(*ends.tolist(), dxfattribs={"layer": str(layer)})

    def _point(self, layer: int, place: Floats, depth: float = 0.0, **attributes: float) -> None:
        x, y = place.tolist()
        self.block.add_point((x, y, depth), dxfattribs={"layer": str(layer), **attributes})

    def _notch(self, notch: Notch, ring: shapely.Geometry) -> None:
        """A point on the boundary for each of its marks: z its depth, thickness its width, angle the way it runs."""
        layer = NOTCH_LAYERS.get(notch.kind, NOTCHES) if self.dialect.astm else NOTCHES
        angle = math.degrees(math.atan2(notch.inward[1], notch.inward[0])) % 360.0
        for place in notch.feet:
            on_line = shapely.get_coordinates(ring.interpolate(ring.project(shapely.Point(place))))[0]
            self._point(layer, on_line, notch.depth, thickness=notch.width, angle=angle)

    def _nick(self, nick: Nick) -> None:
        """As a notch: its foot is the middle of its mouth on the cut line."""
        foot, tip = nick.points[[0, -1 if len(nick.points) == 3 else 0]].mean(axis=0), nick.points[1]
        angle = math.degrees(math.atan2(*(tip - foot)[::-1])) % 360.0
        width = float(np.linalg.norm(nick.points[2] - nick.points[0])) if len(nick.points) == 3 else 0.0
        self._point(NOTCHES, foot, float(np.linalg.norm(tip - foot)), thickness=width, angle=angle)

    def _mark(self, mark: Mark) -> None:
        """A line, or a drill hole with its rim."""
        if len(mark.points) == 1:
            self._point(DRILLS, mark.points[0])
            lines = mark.lines[2:]  # after the cross
        else:
            lines = mark.lines
        for line in lines:
            if len(line) == 2:
                self._line(INTERNAL, line)
                continue
            closed = bool((line[0] == line[-1]).all())
            points = line[:-1] if closed else line
            self._polyline(INTERNAL, points, closed)
            for point in points:
                self._point(CURVES, point)


def _grain(piece: Piece) -> Floats:
    """Every block has a grain line: one whose piece has no arrow lies as its frame does, along +x."""
    if piece.grain is not None:
        return piece.grain
    half = 0.25 * float(np.ptp(piece.sew_line[:, 0]))
    return piece.label.position + np.array([[-half, 0.0], [half, 0.0]])
