"""Ask spyrrow, the strip packing engine, in a child process: kinds of copies and a width in, placements out."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from flatnet.nesting.layout import Copy, Placement, turn, turned_by
from flatnet.parameters import NestingParameters

Floats = NDArray[np.float64]

#: Of every copy the number of its item, degrees, and where the item's origin lies, (2,) mm.
Placed: TypeAlias = list[tuple[int, float, Floats]]
#: Called with the length of the strip that is used, mm, and what lies on it, whenever a shorter one is found.
Shorter = Callable[[float, Placed], None]

#: mm that an outline may be simplified by for the engine; it drops repeated points, which the engine refuses.
SIMPLIFIED = 0.005
#: Where outlines are grown for the engine, corners are cut at this many times as far as edges are moved.
MITRE = 1.5
#: The engine panics where a piece fits exactly: the strip is wider by this part of itself.
EXACT_FIT = 2e-5
#: Threads that it may take, in one search. Up to so few copies two searches of one thread each find more.
THREADS, FEW = 2, 40
#: Seconds that the child may take beyond twice its time before it is ended.
GRACE = 30.0

_CHILD = Path(__file__).with_name("spyrrow_child.py")


class EngineError(Exception):
    """The nesting engine gave no layout; the message says why."""


class EnginePanic(EngineError):
    """It stopped at what it was given."""


@dataclass(frozen=True)
class Item:
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

    @classmethod
    def of(
        cls, region: Polygon, mirrored: bool = False, count: int = 1, rotations: Sequence[float] | None = (0.0,)
    ) -> Item:
        """A region, of which the engine sees the outer ring only."""
        simple = shapely.simplify(region, SIMPLIFIED)
        outline = shapely.get_coordinates(simple.exterior)[:-1] @ turn(0.0, mirrored).T
        centre = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
        return cls(
            (outline - centre).tolist(), centre.tolist(), count, None if rotations is None else list(rotations)
        )

    def rebuilt(self, copy: Copy, rotation: float, place: Floats) -> Placement:
        """The engine's placement of one of its copies in double precision: the nearest of the rotations offered."""
        if self.rotations is not None:
            rotation = min(self.rotations, key=lambda angle: turned_by(rotation, angle))
        x, y = (place - turn(rotation, False) @ self.centre).tolist()
        return Placement(copy.piece, copy.number, copy.mirrored, rotation % 360.0, x, y)


@dataclass(frozen=True)
class Strip:
    """A strip of the engine.

    Attributes
    ----------
    width : mm.
    separation : mm that it keeps between items, and to the rim.
    """

    width: float
    separation: float


def separation_for(gap: float, width: float, area: float) -> float:
    """The engine's separation such that a gap is kept whatever simplifying, rounding and moving back take away, mm.

    It calculates in single precision.

    Parameters
    ----------
    width : of the strip, mm.
    area : of all pieces, mm^2.
    """
    single = float(np.finfo(np.float32).eps) * (2.0 * area / width + width)
    return gap + EXACT_FIT * (width + 2.0 * gap) + 2.0 * SIMPLIFIED + 4.0 * single


def run_engine(
    strip: Strip,
    items: Sequence[Item],
    parameters: NestingParameters,
    shorter: Shorter = lambda *_: None,
    limit: float | None = None,
    threads: int = THREADS,
) -> Placed:
    """Lay the items on as little length of a strip as the engine finds in its time.

    Where it panics, as at some offsets of its own, it is asked again with half the separation round items.

    Parameters
    ----------
    limit : seconds after which the child is ended; None: long after its time.

    Raises
    ------
    EngineError
        Where the engine panics or takes too long.
    """
    limit = limit or 2.0 * parameters.seconds + GRACE
    try:
        return _answer(_problem(strip, items, parameters, threads), limit, shorter)
    except EnginePanic:
        border = 0.5 * strip.separation
        if not border > 0.0:
            raise

    def moved(placed: Placed) -> Placed:
        return [(item, rotation, place + border) for item, rotation, place in placed]

    def told(length: float, placed: Placed) -> None:
        shorter(length + 2.0 * border, moved(placed))

    bare = Strip(strip.width - 2.0 * border, 0.0)
    grown = [replace(item, outline=_grown(item.outline, border)) for item in items]
    return moved(_answer(_problem(bare, grown, parameters, threads), limit, told))


def run_searches(
    strip: Strip, items: Sequence[Item], parameters: NestingParameters, shorter: Shorter = lambda *_: None
) -> list[Placed]:
    """The same, but where there are few copies, with a search on each thread, their seeds one after the other.

    Raises
    ------
    EngineError
        Where the engine panics or takes too long.
    """
    if sum(item.count for item in items) > FEW:
        return [run_engine(strip, items, parameters, shorter)]
    best, lock = float("inf"), threading.Lock()

    def told(length: float, placed: Placed) -> None:
        nonlocal best
        with lock:
            if length < best:
                best = length
                shorter(length, placed)

    seeded = [replace(parameters, seed=parameters.seed + search) for search in range(THREADS)]
    with ThreadPoolExecutor(THREADS) as searches:
        return list(searches.map(lambda one: run_engine(strip, items, one, told, threads=1), seeded))


def _grown(outline: list[list[float]], border: float) -> list[list[float]]:
    """An outline with a border round it, mm."""
    grown = shapely.buffer(Polygon(outline), border, join_style="mitre", mitre_limit=MITRE)
    return shapely.get_coordinates(grown.exterior)[:-1].tolist()


def _problem(strip: Strip, items: Sequence[Item], parameters: NestingParameters, threads: int) -> str:
    """What the child reads."""
    return json.dumps(
        {
            **asdict(strip),
            "items": [asdict(item) for item in items],
            "seconds": parameters.seconds,
            "seed": parameters.seed,
            "workers": threads,
        }
    )


def _answer(problem: str, limit: float, shorter: Shorter) -> Placed:
    """What the child says last; ended when its time is over."""
    try:
        child = subprocess.Popen(
            [sys.executable, str(_CHILD)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
    except OSError as error:
        raise EngineError(f"it could not be started: {error}") from error
    late = threading.Event()

    def end() -> None:
        late.set()
        child.kill()

    timer = threading.Timer(limit, end)
    timer.start()
    said: dict[str, Any] = {}
    try:
        assert child.stdin is not None and child.stdout is not None
        try:
            child.stdin.write(problem)
            child.stdin.close()
        except BrokenPipeError:
            pass  # it died; its status says how
        for line in child.stdout:
            said = json.loads(line)
            if "length" in said:
                shorter(said.pop("length"), _placed(said.pop("placed")))
    except json.JSONDecodeError:
        said = {}
    finally:
        timer.cancel()
        child.kill()
        status = child.wait()
        for stream in (child.stdin, child.stdout):
            if stream is not None:
                stream.close()
    if late.is_set():
        raise EngineError(f"it was still running after {limit:.0f} s")
    if "error" in said:
        raise EnginePanic(str(said["error"]))
    if "placed" not in said:
        raise EngineError(f"it died with status {status}")
    return _placed(said["placed"])


def _placed(records: Sequence[Sequence[float]]) -> Placed:
    return [(int(item), float(rotation), np.array([x, y])) for item, rotation, x, y in records]
