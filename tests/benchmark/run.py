"""What all parts of the benchmark share: the options of a run, tables, child processes."""

from __future__ import annotations

import multiprocessing
import resource
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.linalg.lapack import dpbtrf
from threadpoolctl import threadpool_limits

#: A child starts from a small server: a fork of this process would carry its peak memory along.
CHILDREN = multiprocessing.get_context("forkserver")

#: The matrix that measures the machine: interior unknowns and bandwidth of a mesh of 636 vertices, as the eight
#: boundaries have them in the mean; and the time on the machine that the wanted times are meant for, ms.
BAND_SIZE, BAND_WIDTH, BAND_MS = 1560, 165, 1.0


@dataclass(frozen=True)
class Options:
    """How a run is made, and where it writes."""

    folder: Path
    quick: bool = False
    large: bool = False
    console: Console = field(default_factory=Console)

    def table(self, title: str, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        """Print a table; floats as three digits, the first column to the left."""
        table = Table(title=title, title_justify="left", title_style="bold")
        for index, column in enumerate(columns):
            table.add_column(column, justify="right" if index else "left", no_wrap=True)
        for row in rows:
            table.add_row(*(shown(value) for value in row))
        self.console.print(table)

    def say(self, text: str) -> None:
        self.console.print(text, highlight=False, markup=False)


def shown(value: object) -> str:
    """A value as a table shows it."""
    if value is None:
        return "-"
    if isinstance(value, bool | str):
        return str(value)
    if isinstance(value, int | np.integer):
        return f"{value:,}"
    if isinstance(value, float | np.floating):
        if value == 0.0 or not np.isfinite(value):
            return f"{value:g}"
        if abs(value) < 1e-3:
            return f"{value:.0e}"
        return f"{value:,.0f}" if abs(value) >= 100.0 else f"{value:.3g}"
    return str(value)


def one_blas_thread() -> None:
    """As in a build: the matrices are small, and the sums do not depend on the number of threads."""
    threadpool_limits(limits=1, user_api="blas")


def median_seconds(action: Callable[[], object], runs: int) -> float:
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def band_cholesky_ms() -> float:
    """Median time of the band Cholesky factorisation that all times are compared with, ms."""
    band = np.asfortranarray(np.random.default_rng(0).uniform(-1.0, 1.0, (BAND_WIDTH + 1, BAND_SIZE)))
    band[0] = 2.0 * BAND_WIDTH
    return 1e3 * median_seconds(lambda: dpbtrf(band, lower=1), 21)


@dataclass(frozen=True)
class Measured:
    """What a child process came to: its result, or None where it was stopped or died; peak memory in bytes."""

    result: Any
    peak: int
    seconds: float
    error: str = ""


def in_child(function: Callable[..., Any], *arguments: Any, limit: float | None = None) -> Measured:
    """Call a function of a module in a process of its own, one BLAS thread; stop it after `limit` seconds."""
    here, there = CHILDREN.Pipe(duplex=False)
    process = CHILDREN.Process(target=_child, args=(there, function, arguments))
    start = time.perf_counter()
    process.start()
    there.close()
    try:
        if here.poll(limit):
            return here.recv()
        process.terminate()
        return Measured(None, 0, time.perf_counter() - start, "time limit")
    except EOFError:
        return Measured(None, 0, time.perf_counter() - start, "the process died (out of memory?)")
    finally:
        process.join()


def _child(answer: Connection, function: Callable[..., Any], arguments: Sequence[Any]) -> None:
    one_blas_thread()
    result, error = None, ""
    start = time.perf_counter()
    try:
        result = function(*arguments)
    except Exception:
        error = traceback.format_exc()
    seconds = time.perf_counter() - start
    answer.send(Measured(result, 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, seconds, error))


def map_in_children(function: Callable[[Any], Any], items: Sequence[Any], processes: int = 2) -> list[Any]:
    """The results in order, made by a few processes."""
    with CHILDREN.Pool(processes, initializer=one_blas_thread) as pool:
        return pool.map(function, items, chunksize=1)
