"""Where words and the grain arrow stand on a piece: inside its sew line and clear of each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Geometry, LineString, Polygon

Floats = NDArray[np.float64]

#: Width of a letter over the text height: the mean of common sans-serif faces is 0.5 to 0.6.
LETTER_WIDTH = 0.62
#: Distance of two base lines over the text height.
LINE_PITCH = 1.3
#: Text heights tried for a seam's name, mm; smaller than the last can't be read.
SEAM_HEIGHTS = (4.0, 3.0, 2.0, 1.5, 1.0)
#: Largest text height of a piece's name, mm.
NAME_HEIGHT = 12.0


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
        along = self.direction * 0.5 * LETTER_WIDTH * self.height * max(map(len, self.lines))
        across = np.array([-self.direction[1], self.direction[0]]) * 0.5 * LINE_PITCH * self.height
        across = across * len(self.lines)
        corners = [-along - across, along - across, along + across, -along + across]
        return Polygon(self.position + np.array(corners))


def name_label(lines: Sequence[str], inside: Polygon) -> Label:
    """The text at the centre of the largest circle inside the piece, its box within the circle."""
    size = np.sqrt(inside.area)
    centre, rim = shapely.get_coordinates(shapely.maximum_inscribed_circle(inside, tolerance=0.01 * size))
    diagonal = np.hypot(LETTER_WIDTH * max(map(len, lines)), LINE_PITCH * len(lines))
    height = min(NAME_HEIGHT, 2.0 * float(np.linalg.norm(rim - centre)) / diagonal)
    return Label(tuple(lines), centre, np.array([1.0, 0.0]), height)


def seam_label(text: str, run: Floats, free: Geometry) -> Label | None:
    """The seam's name along its run, inside the piece: large before small, mid-seam before elsewhere.

    Parameters
    ----------
    run : (k, 2) float, mm; the sew line along the seam, the piece on its left.
    free : the part of the piece that is not taken.

    Returns
    -------
    None where the name fits nowhere at a height that can be read.
    """
    line = LineString(run)
    for height in SEAM_HEIGHTS:
        width = LETTER_WIDTH * height * len(text)
        if width > line.length:
            continue
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
    """The middle of the longest line along +x that lies in `free`, (2, 2) float, mm, from tail to head."""
    left, bottom, right, top = free.bounds
    best: tuple[float, Floats] | None = None
    for y in np.linspace(bottom, top, 25)[1:-1]:
        for part in shapely.get_parts(free.intersection(LineString([(left - 1.0, y), (right + 1.0, y)]))):
            # Longer by a hair is no better: round-off must not choose between equal lines.
            if part.geom_type == "LineString" and (best is None or part.length > best[0] * (1 + 1e-9)):
                best = part.length, shapely.get_coordinates(part)
    if best is None:
        return None
    ends = best[1][np.argsort(best[1][:, 0])][[0, -1]]
    middle = ends.mean(axis=0)
    line = middle + 0.7 * (ends - middle)
    line.setflags(write=False)
    return line
