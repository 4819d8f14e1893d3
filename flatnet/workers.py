"""Call a function for many tasks in processes of their own: one that hangs, crashes or eats memory harms no other.

The processes are long-lived; one that dies or overruns its limits is replaced. Results do not depend on how many
there are. They are started by `subprocess` and talk in pickles on their standard input and output: those of
`multiprocessing` would import the script that builds a project, and run it again where it says no
`if __name__ == "__main__"`.
"""

from __future__ import annotations

import faulthandler
import os
import pickle
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import TracebackType
from typing import IO, Any, Literal

import psutil
from threadpoolctl import threadpool_limits

from flatnet.parameters import Limits

#: So often the parent looks at the time and the memory that tasks have taken, s.
_WATCH = 0.1
#: A process that still holds this part of its memory limit after a task is replaced: the next has a right to all of it.
_KEPT = 0.5
#: A process that says no more has ended by then, s.
_LAST_GASP = 2.0
#: So much of what a dying process said is kept, bytes.
_LAST_WORDS = 10_000
_MEGABYTE = 1e6
#: A process that is not ready by then never will be, s; on an idle machine it takes one.
_LONGEST_START = 120.0
#: What a new process says once it can take tasks.
_READY = "ready"


@dataclass(frozen=True)
class Lost:
    """A task that came to no result.

    Attributes
    ----------
    reason : it overran its `time` or its `memory`, or its process died by `itself`.
    seconds, megabytes : how long it took, and the most memory that was seen of its process.
    ending : of a process that died by itself: `signal SIGSEGV`, `exit status 1`.
    details : what it said last (a traceback).
    """

    reason: Literal["time", "memory", "itself"]
    seconds: float
    megabytes: float
    ending: str = ""
    details: str = ""


class Workers:
    """Processes that call one function, at most `count` at a time; they start when the `with` statement is entered.

    Parameters
    ----------
    function : of a module (not of `__main__`), whose BLAS libraries are held to one thread; an exception that it does
        not catch ends its process.
    limits : of one task.
    """

    def __init__(self, function: Callable[..., Any], count: int, limits: Limits) -> None:
        self._function, self._count, self._limits = function, count, limits
        self._heard: queue.SimpleQueue[tuple[_Worker, Any]] = queue.SimpleQueue()
        self._workers: list[_Worker] = []

    def __enter__(self) -> Workers:
        try:
            self._hire(self._count)
        except BaseException:
            self.dismiss()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.dismiss()

    def run(self, tasks: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Any]]:
        """Index and result, or `Lost`, of every task (the function's arguments), as they end; begun in their order."""
        waiting = list(reversed(range(len(tasks))))
        left = len(tasks)
        while left:
            self._hire(min(self._count, left))
            for worker in self._workers:
                if waiting and worker.is_free:
                    index = waiting.pop()
                    worker.give(index, tasks[index])
            for index, result in self._news(waiting):
                left -= 1
                yield index, result

    def _news(self, waiting: list[int]) -> Iterator[tuple[int, Any]]:
        """The tasks that end in the next moment."""
        with suppress(queue.Empty):
            worker, message = self._heard.get(timeout=_WATCH)
            if worker in self._workers:  # not dismissed meanwhile
                yield from self._news_of(worker, message, waiting)
        for worker in list(self._workers):
            overrun = worker.overrun(self._limits)
            if overrun and worker.task is not None:
                self._dismiss(worker)
                yield worker.task, worker.lost(overrun)

    def _news_of(self, worker: _Worker, message: Any, waiting: list[int]) -> Iterator[tuple[int, Any]]:
        """What follows from a message; a process that dies before it is ready takes the next waiting task with it."""
        if message == _READY:
            worker.is_ready = True
            return
        task, worker.task = worker.task, None
        if message is None:
            with suppress(subprocess.TimeoutExpired):  # it is about to end: how it does is worth knowing
                worker.process.wait(_LAST_GASP)
            self._dismiss(worker)
            if task is None and waiting:
                task = waiting.pop()
            if task is not None:
                yield task, worker.lost("itself")
            return
        if worker.megabytes() > _KEPT * self._limits.memory:
            self._dismiss(worker)
        (result,) = message
        assert task is not None
        yield task, result

    def _hire(self, count: int) -> None:
        while len(self._workers) < count:
            self._workers.append(_Worker(self._function, self._heard))

    def _dismiss(self, worker: _Worker) -> None:
        self._workers.remove(worker)
        worker.end()

    def dismiss(self) -> None:
        """End all processes, whatever they are at."""
        for worker in self._workers:
            worker.process.kill()
        for worker in self._workers:
            worker.end()
        self._workers.clear()


class _Worker:
    """One process as its parent sees it, and the thread that listens to it."""

    def __init__(self, function: Callable[..., Any], heard: queue.SimpleQueue[tuple[_Worker, Any]]) -> None:
        self.task: int | None = None
        self.is_ready = False
        self._began = time.monotonic()
        self._most = 0.0
        self._words = tempfile.TemporaryFile()  # noqa: SIM115 - closed when the process has ended
        # The parent's path comes first: what lies in the working directory must not be imported in place of it.
        start = f"import sys; sys.path[:] = {sys.path!r}; from flatnet.workers import serve; serve()"
        with _ctrl_c_held_back():
            self.process = subprocess.Popen(
                [sys.executable, "-c", start], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._words
            )
            threading.Thread(target=self._listen, args=(heard,), daemon=True).start()
        self._send(function)

    @property
    def is_free(self) -> bool:
        return self.is_ready and self.task is None

    def give(self, index: int, task: tuple[Any, ...]) -> None:
        """Hand a task to the process, which must be free."""
        self.task, self._began, self._most = index, time.monotonic(), 0.0
        self._send(task)

    def megabytes(self) -> float:
        """Memory of the process now, MB; 0 where it is gone."""
        with suppress(psutil.Error):
            return float(psutil.Process(self.process.pid).memory_info().rss) / _MEGABYTE
        return 0.0

    def overrun(self, limits: Limits) -> Literal["time", "memory"] | None:
        """Which of the limits the task has overrun; a process that does not get ready is killed."""
        if self.task is None:
            if not self.is_ready and time.monotonic() - self._began > _LONGEST_START:
                self.process.kill()
            return None
        self._most = max(self._most, self.megabytes())
        if self._most > limits.memory:
            return "memory"
        return "time" if time.monotonic() - self._began > limits.seconds else None

    def lost(self, reason: Literal["time", "memory", "itself"]) -> Lost:
        """What there is to say about the task, once the process has ended."""
        code = self.process.returncode
        names = {number.value: number.name for number in signal.Signals}
        ending = f"exit status {code}" if code >= 0 else f"signal {names.get(-code, -code)}"
        return Lost(reason, time.monotonic() - self._began, self._most, ending, self._last_words)

    def end(self) -> None:
        """Kill the process if need be, and wait until it is gone."""
        self.process.kill()
        self.process.wait()
        with suppress(OSError):  # what it no longer reads
            if self.process.stdin is not None:
                self.process.stdin.close()
        size = self._words.seek(0, os.SEEK_END)
        self._words.seek(max(0, size - _LAST_WORDS))
        self._last_words = self._words.read().decode(errors="replace")
        self._words.close()

    def _send(self, message: object) -> None:
        assert self.process.stdin is not None
        with suppress(OSError):  # it has died, as the listener will tell
            _write(message, self.process.stdin)

    def _listen(self, heard: queue.SimpleQueue[tuple[_Worker, Any]]) -> None:
        """Pass on what the process says; None when it says no more."""
        assert self.process.stdout is not None
        try:
            with self.process.stdout as answers:
                for message in _messages(answers):
                    heard.put((self, message))
        finally:
            heard.put((self, None))


def serve() -> None:
    """What a worker process does: receive a function, then call it for every task until the parent is gone."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print must not get among the answers
    faulthandler.enable()
    # Not sys.stdin: Python can't end while a thread reads from that.
    requests = _messages(os.fdopen(os.dup(0), "rb"))
    function = next(requests)
    tasks: queue.SimpleQueue[tuple[Any, ...]] = queue.SimpleQueue()
    threading.Thread(target=_receive, args=(requests, tasks), daemon=True).start()
    # One thread: the matrices are small, threads that wait for each other cost more than they bring, and the
    # sums do not depend on how many there are.
    with threadpool_limits(limits=1, user_api="blas"):
        _write(_READY, answers)
        while True:
            _write((function(*tasks.get()),), answers)


def _receive(requests: Iterator[Any], tasks: queue.SimpleQueue[tuple[Any, ...]]) -> None:
    """Queue the tasks that come in; end the process, whatever it is at, when its parent is gone."""
    for task in requests:
        tasks.put(task)
    os._exit(1)


def _write(message: object, stream: IO[bytes]) -> None:
    # Of the protocols the fifth alone brings read-only arrays back read-only.
    pickle.dump(message, stream, protocol=5)
    stream.flush()


def _messages(stream: IO[bytes]) -> Iterator[Any]:
    """What comes in, until the other side is gone, in the middle of a message or not."""
    with suppress(EOFError, OSError, pickle.UnpicklingError):
        while True:
            yield pickle.load(stream)


@contextmanager
def _ctrl_c_held_back() -> Iterator[None]:
    """What is started meanwhile never sees Ctrl-C, which reaches all processes of a terminal; the parent sees it after.

    Windows has no such thing; there a worker ends of it, and its parent with it.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def usable_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
