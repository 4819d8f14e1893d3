"""The output folder: a build appears in it whole or not at all, and nothing of an earlier build survives."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import TypeVar

from filelock import FileLock

_Content = TypeVar("_Content")

#: What a report says of itself; a folder with such a report is one of ours.
REPORT_FORMAT = "flatnet-report/1"
REPORT = "report.json"
#: Curves and nodes of a build; a layout of several builds has none.
NETWORK = "network.json"
#: Of every vertex of every patch, how far it lies outside the reference surface, mm.
HEIGHTS = "surface_distance.json"
#: What `flatnet verify` adds to a build; of another build it would be a lie.
CERTIFICATE = "certificate.json"
CERTIFICATE_FORMAT = "flatnet-certificate/1"
_STAGING = ".flatnet-unfinished-"
_MANIFEST = "manifest.json"
#: What ends a process from outside; Windows has no SIGHUP.
_ENDING_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
#: A staging folder older than this, s, is what a killed build left.
_ABANDONED = 3600.0
#: So long a build waits for another one that is moving its files, s.
_LONGEST_COMMIT = 60.0


class OutputError(Exception):
    """The output folder can't be used or written."""


def read_of_build(
    path: Path, reader: Callable[[Path], _Content], refusal: Callable[[str], Exception], remedy: str = "build again"
) -> _Content:
    """What a reader makes of a file that a build wrote.

    Parameters
    ----------
    refusal : raised with the file, the reason and the remedy where it can't be read, or the reader finds (ValueError)
        that no build wrote it.
    remedy : what to do where it can't be read.
    """
    try:
        return reader(path)
    except OSError as error:
        raise refusal(f"{path}: can't be read: {error.strerror}; {remedy}") from None
    except ValueError as error:
        raise refusal(f"{path}: {error}; build again") from None


class OutputFolder:
    """Files are written to `staging`, a folder inside OUT, and moved into place by `commit`, report.json last.

    Used in a `with` statement: what was not committed at its end is removed and the earlier build is as it was.
    `commit` removes what an earlier build left (the files that its report lists, and its certificate); other files are
    left alone. Should
    the process be killed in the middle of it, a manifest in the staging folder tells the next build what is ours.

    Raises
    ------
    OutputError
        OUT is a file, can't be written, or holds files but no report of a build: it may be somebody's folder.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._committing = False
        with _explained(folder):
            self._files_of_an_earlier_build()
            self._is_new = not folder.exists()
            folder.mkdir(parents=True, exist_ok=True)
            for left in folder.glob(f"{_STAGING}*"):
                if time.time() - left.stat().st_mtime > _ABANDONED:
                    shutil.rmtree(left, ignore_errors=True)
            # A folder of its own for every build, so that two at once do not write into each other's files.
            self.staging = Path(tempfile.mkdtemp(prefix=_STAGING, dir=folder))

    def __enter__(self) -> OutputFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self._committing:
            shutil.rmtree(self.staging, ignore_errors=True)
            if self._is_new and not any(self.folder.iterdir()):
                self.folder.rmdir()
        if isinstance(error, OSError):
            raise OutputError(_reason(self.folder, error)) from None

    def _files_of_an_earlier_build(self) -> set[str]:
        if not self.folder.exists():
            return set()
        if not self.folder.is_dir():
            raise OutputError(f"{self.folder}: is a file; name a folder for the output")
        known: set[str] = set()
        manifests = [left / _MANIFEST for left in self.folder.glob(f"{_STAGING}*")]
        ours = not any(self.folder.iterdir()) or bool(manifests)
        report = _json(self.folder / REPORT)
        if isinstance(report, dict) and report.get("format") == REPORT_FORMAT:
            ours = True
            known.update(_inside(self.folder, report.get("files")))
            certificate = _json(self.folder / CERTIFICATE)
            if isinstance(certificate, dict) and certificate.get("format") == CERTIFICATE_FORMAT:
                known.add(CERTIFICATE)
        for manifest in manifests:
            known.update(_inside(self.folder, _json(manifest)))
        if not ours:
            raise OutputError(
                f"{self.folder}: holds files, but no {REPORT} of an earlier build; name a new or empty folder"
            )
        return known

    def previous(self, name: str) -> Path:
        """Where an earlier build's file of that name would be."""
        return self.folder / name

    def commit(self, files: Iterable[str]) -> None:
        """Move the written files (paths relative to OUT) into place and remove those of the earlier build."""
        new = sorted(set(files))
        with _explained(self.folder), _not_interrupted(), _alone(self.folder):
            # Asked only now: another build may have come into the folder while this one was at work.
            previous = self._files_of_an_earlier_build()
            (self.staging / _MANIFEST).write_text(json.dumps(sorted(previous.union(new))), encoding="utf-8")
            self._committing = True
            for name in [REPORT, *sorted(previous.difference(new))]:
                (self.folder / name).unlink(missing_ok=True)
            for name in sorted(new, key=lambda name: name == REPORT):
                target = self.folder / name
                target.parent.mkdir(parents=True, exist_ok=True)
                os.replace(self.staging / name, target)
            self._remove_empty_folders(previous)
            shutil.rmtree(self.staging, ignore_errors=True)

    def _remove_empty_folders(self, previous: set[str]) -> None:
        for name in {str(Path(name).parent) for name in previous} - {"."}:
            folder = self.folder / name
            if folder.is_dir() and not any(folder.iterdir()):
                folder.rmdir()


@contextmanager
def _explained(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(_reason(folder, error)) from None


def _reason(folder: Path, error: OSError) -> str:
    return f"{folder}: can't be written: {error.strerror or error}; name another folder for the output, or make room"


def _alone(folder: Path) -> FileLock:
    """One build at a time moves its files; the lock lies outside the folder, which holds nothing but the build."""
    place = f"{os.path.expanduser('~')}\n{folder.resolve()}"
    digest = hashlib.sha256(place.encode()).hexdigest()[:16]
    return FileLock(Path(tempfile.gettempdir()) / f"flatnet-{digest}.lock", timeout=_LONGEST_COMMIT)


@contextmanager
def _not_interrupted() -> Iterator[None]:
    """Ctrl-C and the like have no effect: moving files takes milliseconds and should not stop half way."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # A handler that Python did not set is None, and could not be set again.
    before = {number: handler for number in _ENDING_SIGNALS if (handler := signal.getsignal(number)) is not None}
    for number in before:
        signal.signal(number, signal.SIG_IGN)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _json(path: Path) -> object:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def _inside(folder: Path, names: object) -> set[str]:
    """Those names that are files below the folder: a report that was tampered with deletes nothing elsewhere."""
    if not isinstance(names, list):
        return set()
    root = folder.resolve()
    inside = set()
    for name in names:
        if isinstance(name, str) and name and (root / name).resolve().is_relative_to(root):
            inside.add(name)
    return inside
