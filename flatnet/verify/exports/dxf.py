"""Read the lines of a DXF, plain or in a dialect of the clothing trade: group codes and values, line by line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flatnet.verify.drawing import DrawnLine
from flatnet.verify.exports.lines import drawn_line
from flatnet.verify.written import DamagedError

Floats = NDArray[np.float64]
Pair = tuple[int, str]


@dataclass(frozen=True, eq=False)
class DxfBlock:
    """What a block shows, by layer: `lines`, and `points` (2,) mm each."""

    lines: dict[str, list[DrawnLine]] = field(default_factory=dict)
    points: dict[str, list[Floats]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class DxfContent:
    """The blocks by their names; that of the drawing itself is ""."""

    blocks: dict[str, DxfBlock] = field(default_factory=dict)


def read_dxf(file: str, text: str) -> DxfContent:
    """LINE, LWPOLYLINE, POLYLINE with its VERTEX entities, and POINT.

    Raises
    ------
    DamagedError
        It is no DXF, or cut short.
    """
    try:
        pairs = list(_pairs(text))
        if not pairs or pairs[-1] != (0, "EOF"):
            raise ValueError("it has no EOF at its end")
        content = DxfContent()
        block = ""
        polyline: tuple[str, list[list[float]], bool] | None = None
        for kind, entity in _entities(pairs):
            if kind == "BLOCK":
                block = _first(entity, 2)
            elif kind == "ENDBLK":
                block = ""
            elif kind == "LINE":
                ends = [[float(_first(entity, code)) for code in codes] for codes in ((10, 20), (11, 21))]
                _add(content, block, _first(entity, 8), ends, closed=False)
            elif kind == "POINT":
                place = np.array([float(_first(entity, code)) for code in (10, 20)])
                points = content.blocks.setdefault(block, DxfBlock()).points
                points.setdefault(_first(entity, 8), []).append(place)
            elif kind == "LWPOLYLINE":
                places = zip(*([float(value) for code, value in entity if code == axis] for axis in (10, 20)))
                _add(content, block, _first(entity, 8), list(places), bool(int(_first(entity, 70)) & 1))
            elif kind == "POLYLINE":
                polyline = (_first(entity, 8), [], bool(int(_first(entity, 70, "0")) & 1))
            elif kind == "VERTEX" and polyline is not None:
                polyline[1].append([float(_first(entity, 10)), float(_first(entity, 20))])
            elif kind == "SEQEND" and polyline is not None:
                _add(content, block, *polyline)
                polyline = None
    except ValueError as error:
        raise DamagedError(file, f"is no DXF, or cut short: {error}") from None
    return content


def _pairs(text: str) -> Iterator[Pair]:
    lines = [line.strip() for line in text.splitlines()]
    if len(lines) % 2:
        raise ValueError("a group code has no value")
    for number in range(0, len(lines), 2):
        yield int(lines[number]), lines[number + 1]


def _entities(pairs: list[Pair]) -> Iterator[tuple[str, list[Pair]]]:
    """Each `0 KIND` with what follows it."""
    starts = [number for number, (code, _) in enumerate(pairs) if code == 0]
    for start, end in zip(starts, [*starts[1:], len(pairs)]):
        yield pairs[start][1], pairs[start + 1 : end]


def _first(entity: list[Pair], code: int, default: str | None = None) -> str:
    for other, value in entity:
        if other == code:
            return value
    if default is None:
        raise ValueError(f"an entity lacks group code {code}")
    return default


def _add(content: DxfContent, block: str, layer: str, places: Sequence[Sequence[float]], closed: bool) -> None:
    points = np.array(places)
    if points.ndim != 2 or not np.isfinite(points).all():
        raise ValueError(f"a polyline on layer '{layer}' has no finite vertices")
    lines = content.blocks.setdefault(block, DxfBlock()).lines
    lines.setdefault(layer, []).append(drawn_line(points, closed))
