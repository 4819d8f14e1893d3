"""Read the outlines of a DXF, plain or in a dialect of the clothing trade: group codes and values, line by line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flatnet.verify.written import DamagedError

Floats = NDArray[np.float64]
Pair = tuple[int, str]


@dataclass(frozen=True, eq=False)
class DxfContent:
    """Closed polylines by the block that they are in ("" for the drawing itself), and by layer; (k, 2) each."""

    blocks: dict[str, dict[str, list[Floats]]] = field(default_factory=dict)


def read_dxf(file: str, text: str) -> DxfContent:
    """LWPOLYLINE, and POLYLINE with its VERTEX entities, as far as they are closed.

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
            elif kind == "LWPOLYLINE" and int(_first(entity, 70)) & 1:
                xs, ys = ([float(value) for code, value in entity if code == axis] for axis in (10, 20))
                _add(content, block, _first(entity, 8), np.array([xs, ys]).T)
            elif kind == "POLYLINE":
                polyline = (_first(entity, 8), [], bool(int(_first(entity, 70, "0")) & 1))
            elif kind == "VERTEX" and polyline is not None:
                polyline[1].append([float(_first(entity, 10)), float(_first(entity, 20))])
            elif kind == "SEQEND" and polyline is not None:
                if polyline[2]:
                    _add(content, block, polyline[0], np.array(polyline[1]))
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


def _add(content: DxfContent, block: str, layer: str, points: Floats) -> None:
    if points.ndim != 2 or not np.isfinite(points).all():
        raise ValueError(f"a polyline on layer '{layer}' has no finite vertices")
    content.blocks.setdefault(block, {}).setdefault(layer, []).append(points)
