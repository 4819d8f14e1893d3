"""What is wrong with a project file, and where it stands."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, order=True)
class Mark:
    """A place in the project file; line and column count from 1."""

    line: int
    column: int


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with a project, where it stands and what to do."""

    mark: Mark | None
    message: str

    def located(self, file: Path) -> str:
        """The message behind its place, as an editor finds it: file:line:column."""
        place = f"{file}:{self.mark.line}:{self.mark.column}" if self.mark else str(file)
        return f"{place}: {self.message}"


class ProjectError(Exception):
    """The project is invalid: all its problems together, in file order."""

    def __init__(self, file: Path, problems: list[Problem]) -> None:
        self.file = file
        self.problems = sorted(problems, key=lambda p: p.mark or Mark(0, 0))
        super().__init__("\n".join(problem.located(file) for problem in self.problems))
