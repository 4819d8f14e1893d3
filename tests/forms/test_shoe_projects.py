"""The networks of projects/shoe_1 and projects/shoe_2: an upper on the last, which moves with its measurements."""

from pathlib import Path

import numpy as np
import pytest

from flatnet.cli import main
from flatnet.forms import make_surface
from flatnet.network.assembly import make_network
from flatnet.project import load_project
from tests.written import read_report

PROJECTS = Path(__file__).parents[2] / "projects"

SHOE_1 = ["counter_inner", "counter_outer", "collar", "side_inner", "side_outer", "facing_inner", "facing_outer"]
SHOE_1 += ["tongue", "throat_band", "vamp", "toe_inner", "toe_outer"]
QUARTERS = [f"{level}_quarter_{side}" for level in ("upper", "lower") for side in ("inner", "outer")]
SHOE_2 = [*SHOE_1[:3], *QUARTERS, *SHOE_1[5:]]

LASTS = {
    "46, full": "size: 46, ball: 285, waist: 268, instep: 290",
    "33, flat": "size: 33, heel: 12",
    "40, high, mean forme": "size: 40, heel: 60, toe: pointed, halves: mean",
}


def drawn(file: Path):
    project = load_project(file)
    surface = make_surface(project)
    return surface, make_network(project, surface)


def on_last(folder: Path, name: str, last: str, seconds: str = "5") -> Path:
    """The project's file with another last."""
    text = (PROJECTS / name / "project.yaml").read_text()
    surface = "surface:\n  form: shoe_last\n  size: 42\n  side: right\n"
    assert surface in text and "nesting: {seconds: 5}" in text
    text = text.replace(surface, f"surface: {{form: shoe_last, {last}}}\n")
    file = folder / "project.yaml"
    file.write_text(text.replace("nesting: {seconds: 5}", f"nesting: {{seconds: {seconds}}}"))
    return file


@pytest.fixture(scope="module")
def networks():
    return {name: drawn(PROJECTS / name / "project.yaml") for name in ("shoe_1", "shoe_2")}


@pytest.mark.parametrize("name, pieces", [("shoe_1", SHOE_1), ("shoe_2", SHOE_2)])
def test_the_pieces_by_name(networks, name, pieces):
    _, network = networks[name]
    assert [patch.name for patch in network.patches] == pieces and not network.failed
    assert sorted(network.openings) == ["bottom", "top"]


def test_shoe_2_is_shoe_1_with_a_cut_at_the_arch(networks):
    """On either side one seam more, which runs from the feather edge up to the facing; all other curves agree."""
    (surface, one), (_, two) = networks["shoe_1"], networks["shoe_2"]
    new = {stretch.curve for stretch in two.stretches.values()} - {
        stretch.curve for stretch in one.stretches.values()
    }
    assert new == {"arch_inner", "arch_outer"}
    for side in ("inner", "outer"):
        cut = two.stretches[f"arch_{side}"].vertices
        feather = surface.lines["feather"].points
        assert np.linalg.norm(feather - cut[0], axis=1).min() < 1e-9
        # The arch is hollow at two fifths of the length.
        assert abs(cut[0][0] - 0.4 * 280.0) < 5.0
        facing = np.vstack([s.vertices for s in one.stretches.values() if s.curve == f"facing_{side}"])
        assert np.linalg.norm(facing - cut[-1], axis=1).min() < 8.0  # where edges of 6 mm are sampled anew


@pytest.mark.parametrize("last", LASTS.values(), ids=LASTS.keys())
def test_another_last_moves_the_network(tmp_path, last):
    surface, network = drawn(on_last(tmp_path, "shoe_2", last))
    assert [patch.name for patch in network.patches] == SHOE_2 and not network.failed
    top, bottom = surface.mesh.bounds[1, 2], surface.lines["feather"].points
    length = np.ptp(surface.mesh.vertices[:, 0])
    for stretch in network.stretches.values():
        feet, _ = surface.nearest(stretch.vertices)
        assert np.linalg.norm(feet - stretch.vertices, axis=1).max() < 1e-6, stretch.name
        if stretch.curve == "topline":
            assert (stretch.vertices[:, 2] < top - 3.0).all()
            # Behind, the topline is the back height of the shoe; in front it crosses the ridge at the cone.
            assert stretch.vertices[:, 0].max() < 0.45 * length
        if stretch.curve == "feather":
            apart = np.linalg.norm(stretch.vertices[:, None] - bottom, axis=2).min(axis=1)
            assert apart.max() < 3.0  # between vertices of the rim, 3 mm apart


def test_a_shoe_38_builds(tmp_path):
    """Size 38 in one line: all 14 pieces, exact, and a pair of each."""
    out = tmp_path / "out"
    assert main(["build", str(on_last(tmp_path, "shoe_2", "size: 38", "1")), "-o", str(out)]) == 0
    report = read_report(out)
    for patch in report["patches"]:
        figures = patch["metrics"]
        assert figures["max_flattenability_rad"] <= 1e-9 and figures["max_edge_strain"] <= 1e-8
        assert figures["self_intersections_3d"] == 0
    laid = [(piece["patch"], piece["mirrored"]) for layout in report["layouts"] for piece in layout["pieces"]]
    assert sorted(laid) == sorted((name, mirrored) for name in SHOE_2 for mirrored in (False, True))
