"""What `verify` came to: every check with its worst figure, what failed, and the hashes of the files that it read."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy
import shapely

from flatnet.verify.measured import Measured
from flatnet.verify.written import NotABuildError
from flatnet.version import VERSION

FILE = "certificate.json"
FORMAT = "flatnet-certificate/1"


@dataclass(frozen=True, eq=False)
class Certificate:
    """All that was measured on the files of a build.

    Attributes
    ----------
    measured : in the order of the checks.
    hashes : file -> SHA-256, of every file that was read.
    """

    project: str
    measured: tuple[Measured, ...]
    hashes: Mapping[str, str]

    @property
    def problems(self) -> list[Measured]:
        return [one for one in self.measured if not one.passed]

    @property
    def passed(self) -> bool:
        return not self.problems

    @property
    def checks(self) -> dict[str, list[Measured]]:
        """Check -> what it measured."""
        checks: dict[str, list[Measured]] = {}
        for one in self.measured:
            checks.setdefault(one.check, []).append(one)
        return checks

    def as_dict(self) -> dict[str, object]:
        """The content of certificate.json: the same for the same files, without times."""
        return {
            "format": FORMAT,
            "flatnet": VERSION,
            "project": self.project,
            "passed": self.passed,
            "versions": {
                "python": platform.python_version(),
                "numpy": np.__version__,
                "scipy": scipy.__version__,
                "shapely": shapely.__version__,
            },
            "checks": [_check(name, measured) for name, measured in self.checks.items()],
            "problems": [str(one) for one in self.problems],
            "sha256": dict(sorted(self.hashes.items())),
        }

    def write(self, folder: Path) -> None:
        """Write certificate.json into a folder, whole or not at all.

        Raises
        ------
        NotABuildError
            It can't be written there.
        """
        unfinished = folder / f".{FILE}"
        try:
            unfinished.write_text(json.dumps(self.as_dict(), indent=1) + "\n", encoding="utf-8")
            os.replace(unfinished, folder / FILE)
        except OSError as error:
            raise NotABuildError(f"{folder / FILE}: can't be written: {error.strerror or error}") from None


def worst(measured: Sequence[Measured]) -> Measured:
    """The one nearest to what is allowed, or farthest beyond."""
    return max(measured, key=lambda one: (one.excess, one.amount))


def _check(name: str, measured: Sequence[Measured]) -> dict[str, object]:
    most = worst(measured)
    return {
        "check": name,
        "things": len(measured),
        "failed": sum(not one.passed for one in measured),
        "worst": most.amount if np.isfinite(most.amount) else None,
        "allowed": most.allowed,
        "unit": most.unit,
        "file": most.file,
        "of": most.subject,
    }
