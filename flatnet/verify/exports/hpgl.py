"""Read the lines of an HPGL file: pen movements in units of 0.025 mm."""

from __future__ import annotations

import re

import numpy as np

from flatnet.verify.drawing import DrawnLine
from flatnet.verify.exports.lines import drawn_line
from flatnet.verify.written import DamagedError

UNIT = 0.025  # mm
#: Of every vertex, mm: both coordinates are rounded to whole units.
ROUNDED = UNIT


def read_hpgl(file: str, text: str) -> dict[str, list[DrawnLine]]:
    """Pen -> the lines that it draws."""
    commands = re.sub(r"LB[^\x03]*\x03", "", text)  # labels may hold any letter
    if not commands.endswith(";"):
        raise DamagedError(file, "is cut short: its last command has no end")
    lines: dict[str, list[DrawnLine]] = {}
    pen = "0"
    drawn: list[tuple[int, int]] = []
    for command in [*commands.split(";"), "PU"]:
        name, words = command.strip()[:2], command.strip()[2:]
        if name not in ("PU", "PD", "SP"):
            continue
        if name in ("PU", "SP") and len(drawn) > 1:
            lines.setdefault(pen, []).append(drawn_line(UNIT * np.array(drawn, np.float64)))
        try:
            numbers = [int(word) for word in words.split(",") if word] if name != "SP" else []
            points = list(zip(numbers[::2], numbers[1::2], strict=True))
        except ValueError:
            raise DamagedError(file, f"'{command[:30]}' is no movement of a pen") from None
        if name == "PD":
            drawn += points
        else:
            pen, drawn = (words if name == "SP" else pen), points
    return lines
