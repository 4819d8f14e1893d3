"""Nest copies on a roll with spyrrow, the strip packing engine, in a child process."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.nesting.layout import Copy, Placement, turn
from flatnet.nesting.orientation import fits_anyhow, fitting_rotations
from flatnet.parameters import NestingParameters
from flatnet.project.model import Material

Floats = NDArray[np.float64]

#: mm that an outline may be simplified by for the engine; it drops repeated points, which the engine refuses.
SIMPLIFIED = 0.005
#: The engine panics where a piece fits exactly: the strip is wider by this part of itself.
EXACT_FIT = 2e-5
#: Threads of the engine.
WORKERS = 2
#: Seconds that the child may take beyond twice its time before it is ended.
GRACE = 30.0


class EngineError(Exception):
    """The nesting engine gave no layout; the message says why."""


def nest_on_roll(
    copies: Sequence[Copy], material: Material, parameters: NestingParameters
) -> list[Placement]:
    """Place all copies on as little length of the roll as the engine finds in its time.

    The engine keeps its separation to the rim too and calculates in single precision. So its strip is wider
    by a separation on both sides, and its separation is larger than the gap by what simplifying, rounding and
    moving back onto the roll can take away. Placements are rebuilt in double precision.

    Parameters
    ----------
    copies : every one fits on the material in an allowed rotation; copies of a piece stand together.

    Raises
    ------
    EngineError
        Where the engine panics, takes too long, or leaves copies out.
    """
    groups = [list(group) for _, group in groupby(copies, key=lambda copy: (copy.piece.name, copy.mirrored))]
    items = [_item(group[0], len(group), material) for group in groups]
    margin = EXACT_FIT * (material.width + 2.0 * material.gap)
    area = sum(copy.piece.area for copy in copies)
    single = float(np.finfo(np.float32).eps) * (2.0 * area / material.width + material.width)
    separation = material.gap + margin + 2.0 * SIMPLIFIED + 4.0 * single
    answer = _run(
        {
            "width": material.width + 2.0 * separation + margin,
            "items": [asdict(item) for item in items],
            "separation": separation,
            "seconds": parameters.seconds,
            "seed": parameters.seed,
            "workers": WORKERS,
        },
        2.0 * parameters.seconds + GRACE,
    )
    if Counter(index for index, *_ in answer) != Counter(dict(enumerate(map(len, groups)))):
        raise EngineError("it did not place every copy once")
    placements = []
    for index, rotation, x, y in answer:
        place = np.array([x, y - separation - 0.5 * margin])
        placements.append(_rebuild(groups[index].pop(0), items[index], rotation, place, material))
    return _from_zero(placements)


@dataclass(frozen=True)
class _Item:
    """A kind of copies as the engine takes it.

    Attributes
    ----------
    outline : (x, y) in mm, already mirrored, about the origin, where single precision is finest.
    centre : what was the origin's place in the mirrored piece.
    rotations : degrees; None: any.
    """

    outline: list[list[float]]
    centre: list[float]
    count: int
    rotations: list[float] | None


def _item(copy: Copy, count: int, material: Material) -> _Item:
    region = shapely.simplify(copy.piece.region, SIMPLIFIED)
    outline = shapely.get_coordinates(region.exterior)[:-1] @ turn(0.0, copy.mirrored).T
    centre = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
    free = material.rotations is None and fits_anyhow(copy.piece, material)
    rotations = None if free else fitting_rotations(copy.piece, copy.mirrored, material).tolist()
    return _Item((outline - centre).tolist(), centre.tolist(), count, rotations)


def _run(problem: dict[str, Any], seconds: float) -> list[tuple[int, float, float, float]]:
    """The engine's placements (kind, degrees, x, y) from a child process, ended when its time is over."""
    child = Path(__file__).with_name("spyrrow_child.py")
    try:
        run = subprocess.run(
            [sys.executable, str(child)],
            input=json.dumps(problem), capture_output=True, text=True, timeout=seconds, check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise EngineError(f"it was still running after {seconds:.0f} s") from error
    except OSError as error:
        raise EngineError(f"it could not be started: {error}") from error
    try:
        answer = json.loads(run.stdout)
    except json.JSONDecodeError as error:
        raise EngineError(f"it died with status {run.returncode}") from error
    if "error" in answer:
        raise EngineError(answer["error"])
    return [(kind, rotation, x, y) for kind, rotation, x, y in answer["placed"]]


def _rebuild(copy: Copy, item: _Item, rotation: float, place: Floats, material: Material) -> Placement:
    """The placement in double precision: the nearest of the rotations offered, moved onto the roll."""
    if item.rotations is not None:
        rotation = min(item.rotations, key=lambda angle: abs((rotation - angle + 180.0) % 360.0 - 180.0))
    place = place - turn(rotation, False) @ item.centre
    across = (copy.piece.cut_line @ turn(rotation, copy.mirrored).T)[:, 1] + place[1]
    if across.min() < 0.0:
        place[1] -= across.min()
    elif across.max() > material.width:
        place[1] -= across.max() - material.width
    x, y = place.tolist()
    return Placement(copy.piece, copy.number, copy.mirrored, rotation % 360.0, x, y)


def _from_zero(placements: list[Placement]) -> list[Placement]:
    """The layout moved along the roll to its start."""
    start = min(float(p.place(p.piece.cut_line)[:, 0].min()) for p in placements)
    return [
        Placement(p.piece, p.copy, p.mirrored, p.rotation_deg, p.x_mm - start, p.y_mm) for p in placements
    ]
