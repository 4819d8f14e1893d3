"""Stands here so that pytest puts this folder on the import path (tests share `pieces`), and for what is built once."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from filelock import FileLock

# Before numpy is imported. Two processes of tests with two threads each on two cores take ten times as long for small
# matrices as with one; the build's own workers have one each in any case.
os.environ.setdefault("OMP_NUM_THREADS", "1")

PROJECTS = Path(__file__).parents[1] / "projects"


@pytest.fixture(scope="session")
def once(tmp_path_factory):
    """Name, and what makes a folder -> the folder, made once in a run whichever of its processes asks first.

    Nothing is to be changed in it.
    """
    own = tmp_path_factory.getbasetemp()
    root = own.parent if os.environ.get("PYTEST_XDIST_WORKER") else own

    def folder(name: str, make: Callable[[Path], None]) -> Path:
        made = root / f"{name}.made"
        with FileLock(root / f"{name}.lock"):
            if not made.exists():
                make(root / name)
                made.touch()
        return root / name

    return folder


@pytest.fixture(scope="session")
def built(once):
    """Name of a shipped project -> the folder of its build."""
    from flatnet.cli import main

    def build(name: str) -> Path:
        def make(folder: Path) -> None:
            assert main(["build", str(PROJECTS / name / "project.yaml"), "-o", str(folder)]) == 0

        return once(f"build-{name}", make)

    return build
