"""Where words and the grain arrow stand on a piece: inside its sew line and clear of each other."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Geometry, LineString, Polygon

Floats = NDArray[np.float64]

#: Width of characters over the text height, rounded up from DejaVu Sans, a wide one among the common sans-serif faces.
NARROW, USUAL, CAPITAL, WIDE = 0.42, 0.66, 0.8, 1.0
_NARROW, _WIDE = frozenset(" ',.·/:;|-()[]!ijlIJftr"), frozenset("mwMW@%#+<=>^~×→")
#: Distance of two base lines over the text height.
LINE_PITCH = 1.3
#: Text heights tried along a seam, mm, for its number with its name and for the number alone; smaller can't be read.
SEAM_HEIGHTS, NUMBER_HEIGHTS = (5.0, 4.0, 3.0), (6.0, 5.0, 4.0, 3.0, 2.0)
#: Text stays this far from lines, mm, on small pieces this part of the piece's size.
CLEAR, CLEAR_PART = 0.5, 0.02
#: Largest and smallest text height of a piece's name, mm, and the largest one over the size of the piece.
NAME_HEIGHT, LEAST_NAME_HEIGHT, NAME_PART = 12.0, 2.0, 0.08
#: Each height that is tried for a name is this part of the one before.
NAME_STEP = 0.87
#: Places tried for a name in each direction.
NAME_PLACES = 15
#: Length of an arrow's head, mm, at most this part of the arrow, and half its width over its length.
HEAD, HEAD_PART, HEAD_SPREAD = 6.0, 0.2, 0.4
HALF_HEAD = HEAD * HEAD_SPREAD
#: Part of the room for it that the grain arrow takes.
GRAIN_PART = 0.7
#: A name is broken here, after the sign.
_BREAKS = re.compile(r"(?<=[_.\- ])")


def text_width(text: str) -> float:
    """Width of a line of text over its height, rather too much than too little."""
    return sum(map(_letter_width, text))


def _letter_width(letter: str) -> float:
    if letter in _NARROW:
        return NARROW
    if letter in _WIDE or letter > "\u024f":
        return WIDE
    return CAPITAL if letter.isupper() else USUAL


@dataclass(frozen=True, eq=False)
class Label:
    """Lines of text centred at a place.

    Attributes
    ----------
    position : (2,) float, mm; the centre of the text.
    direction : (2,) float, unit; the way it reads (or backwards: whoever draws it keeps it upright).
    height : mm.
    """

    lines: tuple[str, ...]
    position: Floats
    direction: Floats
    height: float

    def __post_init__(self) -> None:
        self.position.setflags(write=False)
        self.direction.setflags(write=False)

    @property
    def box(self) -> Polygon:
        """The rectangle that the text needs."""
        along = self.direction * 0.5 * self.height * max(map(text_width, self.lines))
        across = np.array([-self.direction[1], self.direction[0]]) * 0.5 * LINE_PITCH * self.height
        across = across * len(self.lines)
        corners = [-along - across, along - across, along + across, -along + across]
        return Polygon(self.position + np.array(corners))


def line_breaks(name: str) -> list[tuple[str, ...]]:
    """A name in one line, in two of about the same width, in three ..., broken at `_`, `-`, `.` and blanks."""
    words = _BREAKS.split(name)
    widths = np.array([text_width(word) for word in words])
    broken = []
    for count in range(1, len(words) + 1):
        line = np.floor((np.cumsum(widths) - 0.5 * widths) / widths.sum() * count).astype(int)
        lines = ("".join(words[i] for i in np.flatnonzero(line == k)).strip() for k in range(count))
        broken.append(tuple(text for text in lines if text))
    return list(dict.fromkeys(broken))


def fitting_label(texts: Sequence[tuple[str, ...]], free: Geometry, heights: Sequence[float]) -> Label:
    """The first text that fits at the largest height, near the middle; what fits nowhere shrinks into a circle.

    Parameters
    ----------
    texts : the same words in other lines, the best first.
    free : where the text may lie.
    heights : to be tried, the largest first.
    """
    return _placed(texts, free, heights) or _shrunk(texts, free)


def _placed(texts: Sequence[tuple[str, ...]], free: Geometry, heights: Sequence[float]) -> Label | None:
    """The first text that fits at the largest height, near the middle."""
    shapely.prepare(free)
    centre, _ = _inscribed_circle(free)
    left, bottom, right, top = free.bounds
    grid = np.meshgrid(np.linspace(left, right, NAME_PLACES), np.linspace(bottom, top, NAME_PLACES))
    places = np.vstack([centre, np.stack(grid, axis=-1).reshape(-1, 2)])
    places = places[shapely.intersects_xy(free, places)]
    places = places[np.argsort(np.linalg.norm(places - centre, axis=1), kind="stable")]
    for height in heights:
        for lines in texts:
            for direction in np.eye(2):
                box = Label(lines, np.zeros(2), direction, height).box.bounds
                boxes = shapely.box(*(places + box[:2]).T, *(places + box[2:]).T)
                fits = shapely.covers(free, boxes)
                if fits.any():
                    return Label(lines, places[np.argmax(fits)], direction, height)
    return None


def _shrunk(texts: Sequence[tuple[str, ...]], free: Geometry) -> Label:
    """The text whose rectangle is largest in the largest circle."""
    centre, radius = _inscribed_circle(free)
    diagonals = [np.hypot(max(map(text_width, lines)), LINE_PITCH * len(lines)) for lines in texts]
    best = int(np.argmin(diagonals))
    return Label(texts[best], centre, np.array([1.0, 0.0]), 2.0 * radius / float(diagonals[best]))


def _inscribed_circle(free: Geometry) -> tuple[Floats, float]:
    size = float(np.sqrt(free.area))
    centre, rim = shapely.get_coordinates(shapely.maximum_inscribed_circle(free, tolerance=0.01 * size))
    return centre, float(np.linalg.norm(rim - centre))


def room_for_text(inside: Polygon, lines: Sequence[Floats]) -> Geometry:
    """The part of a piece that is clear of its rim and of lines, (k, 2) mm each.

    A slit that does not open in the plane is no part of the rim: the sew line is one of the lines.
    """
    clear = min(CLEAR, CLEAR_PART * float(np.sqrt(inside.area)))
    drawn = shapely.union_all([LineString(line) for line in lines])
    return inside.buffer(-clear).difference(drawn.buffer(clear))


def name_label(name: str, lines: Sequence[str], free: Geometry) -> Label:
    """A piece's name and what else is to be said of it, as large as it fits.

    Where not all of it fits at a height that can be read, it is the name and the first of the lines, or the name alone.
    """
    largest = max(min(NAME_HEIGHT, NAME_PART * float(np.sqrt(free.area))), LEAST_NAME_HEIGHT)
    count = int(np.log(LEAST_NAME_HEIGHT / largest) / np.log(NAME_STEP)) + 1
    heights = (largest * NAME_STEP ** np.arange(count)).tolist()
    texts = [[(*broken, *kept) for broken in line_breaks(name)] for kept in (lines, lines[:1], ())]
    found = (_placed(each, free, heights) for each in texts)
    return next((label for label in found if label), None) or _shrunk(texts[-1], free)


def seam_label(number: int, name: str, run: Floats, free: Geometry) -> Label | None:
    """The seam's number and name along its run, inside the piece, or its number where the name has no room.

    Parameters
    ----------
    run : (k, 2) float, mm; the sew line along the seam, the piece on its left.
    free : the part of the piece that is not taken.

    Returns
    -------
    None where not even the number fits at a height that can be read.
    """
    shapely.prepare(free)
    sizes = [(f"{number} {name}", height) for height in SEAM_HEIGHTS]
    sizes += [(str(number), height) for height in NUMBER_HEIGHTS]
    return next((label for text, height in sizes if (label := _along(text, height, run, free))), None)


def _along(text: str, height: float, run: Floats, free: Geometry) -> Label | None:
    """A text of that height along a run: mid-seam before elsewhere, near the line before farther in."""
    line = LineString(run)
    width = text_width(text) * height
    if width > line.length:
        return None
    for part in (0.5, 0.35, 0.65, 0.2, 0.8):
        start = np.clip(part * line.length - 0.5 * width, 0.0, line.length - width)
        tail, head = shapely.get_coordinates(shapely.line_interpolate_point(line, [start, start + width]))
        chord = head - tail
        if np.linalg.norm(chord) < 0.5 * width:  # the seam turns back on itself here
            continue
        direction = chord / np.linalg.norm(chord)
        inward = np.array([-direction[1], direction[0]])
        for distance in (1.0, 2.0):  # where the sew line bulges inwards, its chord lies outside
            label = Label((text,), 0.5 * (tail + head) + distance * height * inward, direction, height)
            if free.covers(label.box):
                return label
    return None


def grain_line(free: Geometry) -> Floats | None:
    """The arrow along +x in the longest run of `free`, its head clear of all else; (2, 2) float, mm, tail and head."""
    best: Floats | None = None
    for part in (1.0, 0.5, 0.25, 0.1):  # of the largest head: on narrow pieces a shorter arrow has a smaller one
        clear = part * HALF_HEAD
        room = _longest_along_x(free.buffer(-clear))
        if room is not None:
            longest = np.inf if part == 1.0 else clear / (HEAD_PART * HEAD_SPREAD)
            middle, length = room.mean(axis=0), min(GRAIN_PART * float(np.ptp(room[:, 0])), longest)
            # Longer by a hair is no better: round-off must not choose between equal lines.
            if best is None or length > np.ptp(best[:, 0]) * (1.0 + 1e-9):
                best = middle + np.array([[-0.5, 0.0], [0.5, 0.0]]) * length
    if best is not None:
        best.setflags(write=False)
    return best


def arrow_head(line: Floats) -> Floats:
    """The barbs and tip of an arrow, (3, 2)."""
    tail, head = line
    length = float(np.linalg.norm(head - tail))
    along = (head - tail) / length
    size = min(HEAD, HEAD_PART * length)
    across = HEAD_SPREAD * size * np.array([-along[1], along[0]])
    barbs: Floats = np.array([head - size * along + across, head, head - size * along - across])
    return barbs


def _longest_along_x(free: Geometry) -> Floats | None:
    """The ends of the longest line along x in a region, (2, 2), from left to right."""
    if free.is_empty:
        return None
    left, bottom, right, top = free.bounds
    longest, best = 0.0, None
    for y in np.linspace(bottom, top, 25)[1:-1]:
        for part in shapely.get_parts(free.intersection(LineString([(left - 1.0, y), (right + 1.0, y)]))):
            if part.geom_type == "LineString" and part.length > longest * (1 + 1e-9):
                longest, best = part.length, shapely.get_coordinates(part)
    return None if best is None else best[np.argsort(best[:, 0])][[0, -1]]
