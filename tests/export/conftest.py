"""Builds and exports that several tests read."""

import pytest
from golden import Golden

from flatnet.cli import main
from flatnet.parameters import EXPORT_FORMATS


@pytest.fixture(scope="session", params=["pants", "shoe_2"])
def golden(request, built, tmp_path_factory):
    """Every format of a shipped project."""
    out, folder = built(request.param), tmp_path_factory.mktemp("exports")
    assert main(["export", str(out), "--format", ",".join(EXPORT_FORMATS), "-o", str(folder)]) == 0
    return Golden(out, folder)
