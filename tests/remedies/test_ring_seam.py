"""The seam that is proposed for a ring joins the nearest places of its loops, and makes it a disk."""

import numpy as np
import pytest
import yaml
from written import read_report

from flatnet.cli import main
from flatnet.diagnosis import diagnose_project
from flatnet.fitting.results import FittedPatch
from flatnet.geometry.triangles import dot


def hem_and_waist():
    """A skirt: a cone round the z axis between two circles, the waist a little off centre."""
    t = np.linspace(0, 2 * np.pi, 48, endpoint=False) + 1.0
    out = np.c_[np.cos(t), np.sin(t), np.full(48, 0.5)]

    def circle(radius, x, z):
        points = np.c_[radius * np.cos(t) + x, radius * np.sin(t), np.full(48, z)]
        return {"closed": True, "points": points.tolist(), "normals": {"per": "point", "values": out.tolist()}}

    return {
        "flatnet": 1,
        "name": "skirt",
        "edge_length": 30,
        "curves": {"hem": circle(200.0, 0.0, 0.0), "waist": circle(120.0, 20.0, 160.0)},
        "patches": {"skirt": {"around": [["hem"], ["-waist"]], "edge_length": 25}},
        "rest": "openings",
        "nesting": {"seconds": 1},
    }


@pytest.fixture
def skirt(tmp_path):
    file = tmp_path / "skirt.yaml"
    file.write_text(yaml.safe_dump(hem_and_waist()))
    return file


def test_the_seam_is_the_shortest_way_between_the_loops(skirt):
    [ring] = diagnose_project(skirt).rings
    seam = ring.network.stretches[ring.seam]
    hem, waist = (np.array(hem_and_waist()["curves"][name]["points"]) for name in ("hem", "waist"))
    gap = np.linalg.norm(hem[:, None] - waist[None], axis=2).min()
    ends = np.linalg.norm(seam.vertices[-1] - seam.vertices[0])
    assert ends == pytest.approx(gap, rel=1e-9)
    assert gap <= seam.length < 1.02 * gap
    np.testing.assert_allclose(dot(np.diff(seam.vertices, axis=0), seam.left_normals), 0.0, atol=1e-9)


def test_the_ring_is_a_disk_with_it_and_its_two_sides_match(skirt):
    found = diagnose_project(skirt)
    [ring] = found.rings
    assert isinstance(ring.result, FittedPatch) and found.all_cured and not found.not_fitted
    forwards, backwards = (run for run in ring.patch.boundary.stretches if run.seam == ring.seam)
    n = len(ring.patch.boundary.vertices)
    first = (forwards.first + np.arange(forwards.count + 1)) % n
    second = (backwards.first + np.arange(backwards.count + 1)) % n
    vertices = ring.patch.boundary.vertices
    np.testing.assert_array_equal(vertices[first], vertices[second[::-1]])
    lengths = [np.linalg.norm(np.diff(ring.result.outline[ids], axis=0), axis=1).sum() for ids in (first, second)]
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-9)


def test_what_is_pasted_for_a_ring_builds(skirt, tmp_path, capsys):
    assert main(["diagnose", str(skirt)]) == 0
    said = capsys.readouterr().out
    pasted = yaml.safe_load(said[said.index("nodes:\n") :])
    content = hem_and_waist()
    content["nodes"] = pasted["nodes"]
    content["curves"] |= pasted["curves"]
    content["patches"] = pasted["patches"]
    skirt.write_text(yaml.safe_dump(content))
    assert main(["build", str(skirt), "-o", str(tmp_path / "out")]) == 0
    [seam] = [seam for seam in read_report(tmp_path / "out")["seams"] if seam["curve"] == "skirt_seam"]
    assert seam["patches"] == ["skirt", "skirt"] and seam["difference_mm"] < 1e-6
