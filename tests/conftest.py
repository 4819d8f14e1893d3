"""Stands here so that pytest puts this folder on the import path (tests share `pieces`), and for what is built once."""

from pathlib import Path

import pytest

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
