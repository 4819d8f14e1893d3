"""Real meshes from end to end: a statue's hole, trousers in four panels, a leg in eight, a slip-on in four pieces."""

import pytest
from body_mesh import leg_project
from moai_hole import moai_project
from pants_mesh import pants_project
from shoe_mesh import shoe_project
from written import read_obj, read_report

from flatnet.cli import main

REAL = {"statue": moai_project, "trousers": pants_project, "leg": leg_project, "slip-on": shoe_project}


@pytest.mark.parametrize("make_project", REAL.values(), ids=REAL.keys())
def test_every_panel_reaches_the_cut_file(make_project, tmp_path):
    project = make_project(tmp_path)
    out = tmp_path / "out"
    assert main(["build", str(project), "-o", str(out)]) == 0
    report = read_report(out)
    laid = {piece["patch"] for layout in report["layouts"] for piece in layout["pieces"]}
    assert laid == {patch["name"] for patch in report["patches"]}
    for patch in report["patches"]:
        figures = patch["metrics"]
        assert figures["max_flattenability_rad"] <= 1e-9
        assert figures["max_edge_strain"] <= 1e-8
        assert figures["boundary_error_mm"] == 0.0
        assert figures["flipped_triangles"] == 0
        assert figures["self_intersections_3d"] == 0
        vertices, _, triangles = read_obj(out / "patches" / f"{patch['name']}.obj")
        assert (len(vertices), len(triangles)) == (figures["vertices"], figures["triangles"])
    for seam in report["seams"]:
        if len(seam["sides"]) == 2:
            assert seam["difference_mm"] <= 1e-6
