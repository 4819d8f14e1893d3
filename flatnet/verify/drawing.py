"""Read the SVG of a layout or a piece: the page, and every piece's lines where they stand on it."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property
from xml.etree import ElementTree

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.verify.written import DamagedError

Floats = NDArray[np.float64]

_SVG = "{http://www.w3.org/2000/svg}"
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


@dataclass(frozen=True, eq=False)
class DrawnLine:
    """(k, 2) float, mm; no point is repeated at the end of a closed one."""

    points: Floats
    closed: bool


@dataclass(frozen=True, eq=False)
class DrawnPiece:
    """A piece on the page, x to the right and y down.

    Attributes
    ----------
    linear, shift : (2, 2) and (2,) float; a point p of its own frame stands at linear p + shift.
    lines : class of a path -> its lines in the piece's own frame, mm.
    """

    file: str
    patch: str
    copy: int
    mirrored: bool
    linear: Floats
    shift: Floats
    lines: dict[str, list[DrawnLine]]

    def __str__(self) -> str:
        return f"{self.patch} copy {self.copy}{' (mirrored)' if self.mirrored else ''}"

    def closed(self, kind: str) -> list[Floats]:
        """Its closed lines of a class, as they stand on the page."""
        lines = self.lines.get(kind, [])
        if not lines or not all(line.closed and len(line.points) >= 3 for line in lines):
            raise DamagedError(self.file, f"{self}: has no closed path '{kind}'")
        return [line.points @ self.linear.T + self.shift for line in lines]

    @cached_property
    def sew_line(self) -> Floats:
        """On the page, (n, 2)."""
        return self.closed("sew")[0]

    @cached_property
    def region(self) -> shapely.Polygon:
        """What is cut out of the page: inside the first cut line and outside the others."""
        outline, *holes = self.closed("cut")
        polygon = shapely.Polygon(outline, holes)
        return polygon if polygon.is_valid else shapely.make_valid(polygon, method="structure", keep_collapsed=False)


@dataclass(frozen=True, eq=False)
class Drawing:
    """A page.

    Attributes
    ----------
    size : width and height, mm.
    view_box : (4,) float: left, top, width, height in units of the drawing.
    lines : class of a path outside all pieces -> its lines.
    """

    size: Floats
    view_box: Floats
    lines: dict[str, list[DrawnLine]]
    pieces: list[DrawnPiece] = field(default_factory=list)

    @property
    def off_scale(self) -> float:
        """How far the page is from one unit of the drawing for each mm, from its upper left corner on; mm."""
        return float(np.abs(self.size - self.view_box[2:]).max() + np.abs(self.view_box[:2]).max())


def read_drawing(file: str, text: str) -> Drawing:
    """Read an SVG of a build.

    Raises
    ------
    DamagedError
        It is no XML, cut short, or not drawn as docs/report.md says.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise DamagedError(file, f"is no SVG, or cut short: {error}") from None
    try:
        size = np.array([_millimetres(root.attrib[side]) for side in ("width", "height")])
        view_box = _numbers(root.attrib["viewBox"])
        if len(view_box) != 4:
            raise ValueError("viewBox has not four numbers")
        drawing = Drawing(size, view_box, {})
        _walk(root, np.eye(2), np.zeros(2), drawing, file)
    except KeyError as error:
        raise DamagedError(file, f"an attribute is missing: {error}") from None
    except ValueError as error:
        raise DamagedError(file, str(error)) from None
    return drawing


def _walk(element: ElementTree.Element, linear: Floats, shift: Floats, drawing: Drawing, file: str) -> None:
    """All below an element: groups of pieces, and paths that belong to none."""
    for child in element:
        own, moved = _matrix(child.get("transform"))
        placed, at = linear @ own, linear @ moved + shift
        if child.tag == f"{_SVG}g" and child.get("class") == "piece":
            drawing.pieces.append(_piece(child, placed, at, file))
        elif child.tag == f"{_SVG}path":
            for line in _lines(child.attrib["d"]):
                line = DrawnLine(line.points @ placed.T + at, line.closed)
                drawing.lines.setdefault(child.get("class", ""), []).append(line)
        else:
            _walk(child, placed, at, drawing, file)


def _piece(group: ElementTree.Element, linear: Floats, shift: Floats, file: str) -> DrawnPiece:
    piece = DrawnPiece(
        file=file,
        patch=group.attrib["data-patch"],
        copy=int(group.attrib["data-copy"]),
        mirrored={"true": True, "false": False}[group.attrib["data-mirrored"]],
        linear=linear,
        shift=shift,
        lines={},
    )
    for path in group.iter(f"{_SVG}path"):
        if path.get("transform"):
            raise ValueError(f"{piece}: a path has a transform of its own")
        piece.lines.setdefault(path.get("class", ""), []).extend(_lines(path.attrib["d"]))
    return piece


def _lines(commands: str) -> list[DrawnLine]:
    """The parts of a path of `M x,y x,y ... Z`, straight lines between absolute points."""
    lines = []
    for part in commands.split("M")[1:]:
        points = part.strip()
        closed = points.endswith("Z")
        numbers = _numbers(points[:-1] if closed else points)
        if len(numbers) % 2:
            raise ValueError(f"path 'M {points[:30]}': an odd number of coordinates")
        if len(numbers) < 6 and closed:
            raise ValueError(f"path 'M {points[:30]}': no outline")
        lines.append(DrawnLine(numbers.reshape(-1, 2), closed))
    if not commands.startswith("M") or not lines:
        raise ValueError(f"path '{commands[:30]}' does not begin with M")
    return lines


def _matrix(transform: str | None) -> tuple[Floats, Floats]:
    if transform is None:
        return np.eye(2), np.zeros(2)
    match = re.fullmatch(r"\s*matrix\((.*)\)\s*", transform)
    numbers = _numbers(match.group(1)) if match else np.empty(0)
    if len(numbers) != 6:
        raise ValueError(f"transform '{transform}' is no matrix of six numbers")
    a, b, c, d, x, y = numbers
    return np.array([[a, c], [b, d]]), np.array([x, y])


def _millimetres(text: str) -> float:
    match = re.fullmatch(rf"({_NUMBER})mm", text)
    if not match:
        raise ValueError(f"a page of '{text}' is not in mm")
    return float(match.group(1))


def _numbers(text: str) -> Floats:
    words = text.replace(",", " ").split()
    for word in words:
        if not re.fullmatch(_NUMBER, word):
            raise ValueError(f"'{word[:30]}' is no number")
    return np.array(words, dtype=float)
