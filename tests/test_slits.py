"""A slit: cut open in the mesh, closed in space; on a dome it opens as a dart when flattened, on a plane it doesn't."""

import numpy as np
import pytest
import yaml
from written import read_obj, read_report

from flatnet.cli import main

RADIUS, RIM, TIP = 150.0, 0.7, 0.15  # mm; rad from the top of the dome, or parts of the radius on the plane


def dome(r, t):
    normals = np.c_[np.sin(r) * np.cos(t), np.sin(r) * np.sin(t), np.cos(r) + 0 * t]
    return RADIUS * normals, normals


def plane(r, t):
    return RADIUS * np.c_[r * np.cos(t), r * np.sin(t), 0 * t], np.tile([0.0, 0.0, 1.0], (len(t), 1))


def project(surface):
    t = np.linspace(0, 2 * np.pi, 49)
    rim, rim_normals = surface(np.full(49, RIM), t)
    r = np.linspace(RIM, TIP, 7)
    dart, dart_normals = surface(r, 0 * r)
    return {
        "flatnet": 1,
        "name": "cup",
        "edge_length": 14,
        "nodes": {"hem": rim[0].tolist(), "tip": dart[-1].tolist()},
        "curves": {
            "rim": {"from": "hem", "to": "hem", "points": rim[1:-1].tolist(), "normals": rim_normals.tolist()},
            "dart": {
                "from": "hem",
                "to": "tip",
                "points": dart[1:-1].tolist(),
                "normals": dart_normals.tolist(),
                "slit": True,
            },
        },
        "patches": {"cup": {"around": ["rim", "dart", "-dart"], "grain": [1, 0, 0]}},
        "rest": "openings",
    }


@pytest.mark.parametrize("surface, opens", [(dome, True), (plane, False)])
def test_the_legs_of_a_dart_are_equal_and_it_opens_where_the_surface_is_round(surface, opens, tmp_path):
    (tmp_path / "cup.yaml").write_text(yaml.safe_dump(project(surface)))
    assert main(["build", str(tmp_path / "cup.yaml"), "-o", str(tmp_path / "out")]) == 0
    report = read_report(tmp_path / "out")
    vertices, flat, _ = read_obj(tmp_path / "out" / "patches" / "cup.obj")
    (dart,) = [seam for seam in report["seams"] if seam["curve"] == "dart"]
    first, second = (np.array(side["vertices"]) for side in dart["sides"])
    assert dart["patches"] == ["cup", "cup"]
    assert first[-1] == second[-1]  # the tip is one vertex, the rest are two
    assert not set(first[:-1]) & set(second[:-1])
    assert np.array_equal(vertices[first], vertices[second])
    legs = [np.linalg.norm(np.diff(flat[side], axis=0), axis=1) for side in (first, second)]
    assert np.abs(legs[0] - legs[1]).max() <= 1e-6
    opening = np.linalg.norm(flat[first[0]] - flat[second[0]])
    assert opening > 14 if opens else opening <= 1e-6  # more than a mesh edge, or nothing
