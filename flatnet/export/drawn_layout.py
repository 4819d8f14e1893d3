"""Read a layout's SVG back: the lines of every piece where they stand on the page."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_SVG = "{http://www.w3.org/2000/svg}"


@dataclass(frozen=True, eq=False)
class DrawnPiece:
    """A piece as the page shows it, in mm, x to the right and y down.

    Attributes
    ----------
    linear, shift : (2, 2) and (2,) float; a point of the piece's own frame stands at linear p + shift.
    lines : class of a path (`cut`, `sew`, `grain` ...) -> its parts, each (k, 2) float; no point is repeated.
    """

    patch: str
    mirrored: bool
    linear: Floats
    shift: Floats
    lines: dict[str, list[Floats]]

    def place(self, points: Floats) -> Floats:
        """From the piece's own frame to the page, (k, 2)."""
        return points @ self.linear.T + self.shift


def read_layout(path: Path) -> list[DrawnPiece]:
    """The pieces of a layout that `flatnet.export.svg` drew.

    Raises
    ------
    ValueError
        The file is no layout of ours.
    """
    try:
        root = ElementTree.parse(path).getroot()
        return [_piece(group) for group in root.iter(f"{_SVG}g") if group.get("class") == "piece"]
    except (ElementTree.ParseError, KeyError, TypeError, ValueError) as error:
        raise ValueError(f"not a layout of flatnet: {error}") from None


def _piece(group: ElementTree.Element) -> DrawnPiece:
    a, b, c, d, x, y = _numbers(group.attrib["transform"])
    piece = DrawnPiece(
        patch=group.attrib["data-patch"],
        mirrored=group.attrib["data-mirrored"] == "true",
        linear=np.array([[a, c], [b, d]]),
        shift=np.array([x, y]),
        lines={},
    )
    for path in group.iter(f"{_SVG}path"):
        parts = [np.reshape(_numbers(part), (-1, 2)) for part in path.attrib["d"].split("M")[1:]]
        piece.lines.setdefault(path.attrib["class"], []).extend(piece.place(part) for part in parts)
    return piece


def _numbers(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"[-+.\d]+(?:e[-+]?\d+)?", text)]
