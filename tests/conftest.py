"""Stands here so that pytest puts this folder on the import path (tests share `pieces`), and for what is built once."""

import os
from pathlib import Path

import pytest

# Before numpy is imported. Two processes of tests with two threads each on two cores take ten times as long for small
# matrices as with one; the build's own workers have one each in any case.
os.environ.setdefault("OMP_NUM_THREADS", "1")

PROJECTS = Path(__file__).parents[1] / "projects"


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """Name of a shipped project -> the folder of its build; each is built once in a run of the tests."""
    from flatnet.cli import main

    folders: dict[str, Path] = {}

    def build(name: str) -> Path:
        if name not in folders:
            folder = tmp_path_factory.mktemp(name) / "out"
            assert main(["build", str(PROJECTS / name / "project.yaml"), "-o", str(folder)]) == 0
            folders[name] = folder
        return folders[name]

    return build
