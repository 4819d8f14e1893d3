"""The terminal's lines: what failed and what is doubtful, with what to do."""

from pathlib import Path

from flatnet.report.summary import counted, layout_lines, summary_lines

FINDING = {"message": "the normals are opposed at node 'toe'.", "remedy": "Turn one round.", "patch": ""}
METRICS = {
    "vertices": 12,
    "max_flattenability_rad": 1e-12,
    "mean_normal_deviation_deg": 1.0,
    "bending": 2.0,
    "max_dihedral_deg": 3.0, "wrinkles": {"turning_deg": 0.0},
}


def test_failures_and_warnings_say_what_and_what_to_do():
    made = {"name": "vamp", "status": "ok", "failure": None, "metrics": METRICS, "seconds": {"warp": 0.1}}
    failed = {"name": "toe", "status": "failed", "failure": {**FINDING, "code": "folded"}, "warnings": []}
    report = {
        "status": "partial",
        "patches": [{**made, "warnings": [{**FINDING, "code": "opposed_normals"}]}, failed],
        "seams": [],
        "seam_walk": [],
        "findings": [{**FINDING, "code": "draft_layout"}],
        "layouts": [],
    }
    lines = summary_lines(report, Path("out"))
    said = "the normals are opposed at node 'toe'. Turn one round."
    assert lines[0].startswith("vamp  ok")
    assert lines[1] == f"toe   FAILED folded: {said}"
    assert lines[2] == f"vamp: warning opposed_normals: {said}"
    assert lines[3] == f"warning draft_layout: {said}"
    assert lines[4].startswith("partial: 1 of 2 patches made")


def test_one_piece_two_pieces():
    assert [counted(n, "piece") for n in range(3)] == ["0 pieces", "1 piece", "2 pieces"]
    assert counted(2, "patch", "patches") == "2 patches"


def test_of_a_drawn_hide_the_size_is_told_to_a_tenth():
    hide = {"outline": [[0, 0], [604.38, 0], [604.38, 430.728], [0, 430.728]], "defects": [], "zones": []}
    layout = {"file": "layout-leather.svg", "hide": hide, "sheet_width_mm": 430.728, "pieces": [{}], "utilisation": 0.5}
    report = {"status": "ok", "patches": [], "findings": [], "layouts": [{**layout, "draft": False}]}
    assert layout_lines(report, Path("out"))[0].endswith("1 piece on a hide of 430.7 x 604 mm, 50.0 % used")


def test_a_seam_without_notches_is_one_length():
    walk = {"a": "side", "b": "side", "legs": [{}], "largest_difference_mm": 0.0, "warnings": []}
    report = {"status": "ok", "patches": [], "seam_walk": [walk], "seams": [], "findings": [], "layouts": []}
    assert "seam walk: 1 seam, 1 length from notch to notch" in summary_lines(report, Path("out"))[0]
