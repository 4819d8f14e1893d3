"""The output folder: a build appears in it whole or not at all, and nothing of an earlier build survives."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable
from pathlib import Path

#: What a report says of itself; a folder with such a report is one of ours.
REPORT_FORMAT = "flatnet-report/1"
REPORT = "report.json"
_STAGING = ".flatnet-unfinished"
_MANIFEST = "manifest.json"


class OutputError(Exception):
    """The output folder can't be used."""


class OutputFolder:
    """Files are written to `staging`, a folder inside OUT, and moved into place by `commit`, report.json last.

    What an earlier build left (the files that its report lists) is removed by `commit`; other files are left
    alone. A manifest in the staging folder makes an interrupted commit recoverable.

    Raises
    ------
    OutputError
        OUT is a file, can't be written, or holds files but no report of a build: it may be somebody's folder.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.staging = folder / _STAGING
        try:
            self._previous = self._files_of_an_earlier_build()
            shutil.rmtree(self.staging, ignore_errors=True)
            self.staging.mkdir(parents=True)
        except OSError as error:
            raise OutputError(f"{folder}: can't be used as the output folder: {error.strerror}") from None

    def _files_of_an_earlier_build(self) -> set[str]:
        if not self.folder.exists():
            return set()
        if not self.folder.is_dir():
            raise OutputError(f"{self.folder}: is a file; name a folder for the output")
        known: set[str] = set()
        ours = not any(self.folder.iterdir()) or self.staging.exists()
        report = _json(self.folder / REPORT)
        if isinstance(report, dict) and report.get("format") == REPORT_FORMAT:
            ours = True
            known.update(_inside(self.folder, report.get("files")))
        known.update(_inside(self.folder, _json(self.staging / _MANIFEST)))
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
        (self.staging / _MANIFEST).write_text(json.dumps(sorted(self._previous.union(new))), encoding="utf-8")
        for name in [REPORT, *sorted(self._previous.difference(new))]:
            (self.folder / name).unlink(missing_ok=True)
        for name in sorted(new, key=lambda name: name == REPORT):
            target = self.folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            os.replace(self.staging / name, target)
        self._remove_empty_folders()
        self.discard()

    def discard(self) -> None:
        """Remove what was written and not committed."""
        shutil.rmtree(self.staging, ignore_errors=True)

    def _remove_empty_folders(self) -> None:
        for name in {str(Path(name).parent) for name in self._previous} - {"."}:
            folder = self.folder / name
            if folder.is_dir() and not any(folder.iterdir()):
                folder.rmdir()


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
