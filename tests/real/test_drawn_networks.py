"""Networks drawn by others, without normals: their faces are known, because their graphs have one embedding only."""

from pathlib import Path

import pytest

from flatnet.build import check
from flatnet.start import DrawingOptions, faces

NETWORKS = Path(__file__).parents[3] / "shared" / "data" / "networks"


@pytest.mark.parametrize(
    ("drawing", "count", "findings"),
    [("cassie/08-1-2.json", 14, ["trimmed_end", "trimmed_end"]), ("vns/phone_flowrep.obj", 56, [])],
    ids=["shoe", "telephone"],
)
def test_faces(drawing, count, findings, tmp_path):
    if not (NETWORKS / drawing).exists():
        pytest.skip(f"the network is not there: {NETWORKS / drawing}")
    started = faces(NETWORKS / drawing, tmp_path / "net.yaml", DrawingOptions(units="100", up="y"))
    assert sum(line.startswith("  face_") for line in started.lines) == count
    project, network = check(tmp_path / "net.yaml")
    assert network.face_count == len(network.patches) == count and not network.failed
    assert network.euler_characteristics == (2,)
    assert [finding.code for finding in project.findings] == findings
