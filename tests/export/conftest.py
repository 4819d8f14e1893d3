"""Builds and exports that several tests read."""

from pathlib import Path

import pytest
from golden import Golden

from flatnet.cli import main
from flatnet.parameters import EXPORT_FORMATS


@pytest.fixture(scope="session", params=["pants", "shoe_2"])
def golden(request, built, once):
    """Every format of a shipped project."""
    out = built(request.param)

    def make(folder: Path) -> None:
        assert main(["export", str(out), "--format", ",".join(EXPORT_FORMATS), "-o", str(folder)]) == 0

    return Golden(out, once(f"exports-{request.param}", make))
