"""One build for all tests of the room."""

import shutil

import pytest
from small_build import PROJECT

from flatnet.cli import main


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """The folder of a small build; nobody changes it."""
    folder = tmp_path_factory.mktemp("roof")
    (folder / "project.yaml").write_text(PROJECT)
    assert main(["build", str(folder / "project.yaml"), "-o", str(folder / "out"), "--workers", "1"]) == 0
    return folder / "out"


@pytest.fixture
def out(built, tmp_path):
    """A copy of it, to be spoilt."""
    return shutil.copytree(built, tmp_path / "out")
