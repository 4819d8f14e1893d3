"""Write a sheet as HPGL for pen plotters and cutters: one pen for each meaning, the cut line last.

A plain text format: `PU` and `PD` with whole numbers of 0.025 mm. Written here, since the libraries for it drive
machines or come with a whole vector editor.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flatnet.export.lines import KINDS, Line, Words, piece_lines, placed_words
from flatnet.export.seven_bit import Transliterated
from flatnet.nesting.layout import Layout

Floats = NDArray[np.float64]

#: Units of HPGL in a mm.
UNITS = 40.0
#: The pen of each meaning.
PENS = {"cut": 1, "sew": 2, "notch": 3, "nick": 1, "internal": 4, "grain": 5, "text": 6}
#: `SI` is given the size of a letter in cm; its width over its height. A plotter adds half a width between two.
LETTER_WIDTH = 0.42
#: A label ends with this character, and `LO4` centres it on its base line.
END = "\x03"


def write_hpgl(path: Path, layout: Layout) -> list[str]:
    """Draw one sheet, its lower left corner at the origin.

    Returns
    -------
    notes : what had to be transliterated.
    """
    plain = Transliterated()
    lines: dict[str, list[Line]] = {kind: [] for kind in KINDS}
    for placement in layout.placements:
        for line in piece_lines(placement.piece):
            lines[line.kind].append(line.moved(placement))
    commands = ["IN", f"SP{PENS['text']}", "LO4"]
    for placement in layout.placements:
        commands += [_label(words, plain) for words in placed_words(placement)]
    for kind in KINDS:
        if lines[kind]:
            commands += [f"SP{PENS[kind]}", *(_drawn(line) for line in lines[kind])]
    commands += ["PU", "SP0"]
    path.write_text(";".join(commands) + ";", encoding="ascii")
    return plain.notes(path.name)


def _drawn(line: Line) -> str:
    points = np.concatenate([line.points, line.points[:1]]) if line.closed else line.points
    places = [f"{x},{y}" for x, y in np.rint(points * UNITS).astype(int).tolist()]
    return f"PU{places[0]};PD{','.join(places[1:])}"


def _label(words: Words, plain: Transliterated) -> str:
    x, y = np.rint(words.position * UNITS).astype(int).tolist()
    direction = f"DI{math.cos(words.angle) + 0.0:.4f},{math.sin(words.angle) + 0.0:.4f}"
    size = f"SI{0.1 * LETTER_WIDTH * words.height:.4f},{0.1 * words.height:.4f}"
    return f"PU{x},{y};{direction};{size};LB{plain(words.text)}{END}"
