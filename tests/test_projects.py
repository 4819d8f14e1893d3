"""Every shipped project, built as a user would and measured on the written files."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from written import (
    angle_sums,
    boundary_vertices,
    edges,
    lengths,
    read_obj,
    read_report,
    sewn_outlines,
)

from flatnet.cli import main

ROOT = Path(__file__).parents[1]
PROJECTS = sorted(path.parent.name for path in (ROOT / "projects").glob("*/project.yaml"))


@pytest.fixture(scope="module", params=PROJECTS)
def out(request, built):
    """The folder of one project's build; the command's exit status is 0."""
    return built(request.param)


@pytest.fixture(scope="module")
def report(out):
    return read_report(out)


@pytest.fixture(scope="module")
def meshes(out, report):
    return {patch["name"]: read_obj(out / "patches" / f"{patch['name']}.obj") for patch in report["patches"]}


def test_the_folder_holds_what_the_report_lists(out, report):
    written = sorted(path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file())
    assert written == sorted(report["files"])
    assert report["status"] == "ok"


#: Vertices of each example in the paper's Table 1, those on two patches counted twice.
TABLE_1 = {"wrinkle": 654, "moai": 1335, "pants": 5010, "shoe_1": 1459, "shoe_2": 1460}


def test_the_papers_examples_have_the_papers_mesh_sizes(report):
    if report["project"] in TABLE_1:
        vertices = sum(patch["metrics"]["vertices"] for patch in report["patches"])
        assert vertices == pytest.approx(TABLE_1[report["project"]], rel=0.1)


#: What some projects promise: material -> pieces, and sheets that they lie on.
CUT_FROM = {
    "moai": {"copper": (1, 1)},
    "boat": {"plywood": (5, 2)},
    "bag": {"leather": (7, 1), "lining": (5, 1)},
}


def test_the_pieces_lie_on_the_sheets_that_the_readme_promises(report):
    if report["project"] in CUT_FROM:
        laid = {}
        for layout in report["layouts"]:
            pieces, sheets = laid.get(layout["material"], (0, 0))
            laid[layout["material"]] = (pieces + len(layout["pieces"]), sheets + 1)
        assert laid == CUT_FROM[report["project"]]


def test_every_interior_vertex_is_flattenable(meshes):
    for vertices, _, triangles in meshes.values():
        interior = np.setdiff1d(np.arange(len(vertices)), boundary_vertices(triangles))
        assert len(interior) > 0
        defects = angle_sums(vertices, triangles)[interior] - 2 * np.pi
        assert np.abs(defects).max() <= 1e-9


def test_flattening_strains_no_edge_and_turns_no_triangle_over(meshes):
    for vertices, flat, triangles in meshes.values():
        pairs = edges(triangles)
        assert np.abs(lengths(flat, pairs) / lengths(vertices, pairs) - 1).max() <= 1e-8
        u, v = flat[triangles[:, 1]] - flat[triangles[:, 0]], flat[triangles[:, 2]] - flat[triangles[:, 0]]
        assert (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] > 0).all()


def test_no_hinge_is_folded(meshes):
    for vertices, _, triangles in meshes.values():
        normals = np.cross(
            vertices[triangles[:, 1]] - vertices[triangles[:, 0]], vertices[triangles[:, 2]] - vertices[triangles[:, 0]]
        )
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        faces_of = {}
        for face, (a, b, c) in enumerate(triangles):
            for edge in ((a, b), (b, c), (c, a)):
                faces_of.setdefault(tuple(sorted(edge)), []).append(face)
        across = np.array([pair for pair in faces_of.values() if len(pair) == 2])
        cosines = np.einsum("ij,ij->i", normals[across[:, 0]], normals[across[:, 1]])
        assert cosines.min() > np.cos(np.radians(120))


def test_patches_interpolate_the_network_and_share_its_vertices_bit_by_bit(out, report, meshes):
    import json

    curves = {c["name"]: np.array(c["vertices"]) for c in json.loads((out / "network.json").read_text())["curves"]}
    for seam in report["seams"]:
        for side in seam["sides"]:
            vertices = meshes[side["patch"]][0][side["vertices"]]
            assert np.array_equal(vertices, curves[seam["curve"]])


def test_both_sides_of_every_seam_are_equally_long_when_flat(report, meshes):
    for seam in report["seams"]:
        sides = [meshes[side["patch"]][1][side["vertices"]] for side in seam["sides"]]
        steps = [np.linalg.norm(np.diff(side, axis=0), axis=1) for side in sides]
        assert steps[0].sum() == pytest.approx(seam["length_3d_mm"], abs=1e-6)
        if len(steps) == 2:
            assert np.abs(steps[0] - steps[1]).max() <= 1e-6
            assert abs(steps[0].sum() - steps[1].sum()) <= 1e-6


def test_the_drawing_shows_the_flat_coordinates_to_two_microns(out, report, meshes):
    for layout in report["layouts"]:
        drawn = sewn_outlines(out / layout["file"])
        assert len(drawn) == len(layout["pieces"])
        for piece in layout["pieces"]:
            _, flat, triangles = meshes[piece["patch"]]
            outline = flat[boundary_vertices(triangles)]
            turn = np.radians(piece["rotation_deg"])
            rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            mirror = np.diag([1.0, -1.0 if piece["mirrored"] else 1.0])
            placed = outline @ (rotation @ mirror).T + [piece["x_mm"], piece["y_mm"]]
            seen = placed * [1.0, -1.0] + [0.0, layout["sheet_width_mm"]]
            miss = np.linalg.norm(drawn[piece["patch"], piece["copy"]] - seen, axis=1)
            assert miss.max() <= 0.002


def test_the_figures_of_the_report_are_those_of_the_files(report, meshes):
    for patch in report["patches"]:
        vertices, flat, triangles = meshes[patch["name"]]
        figures = patch["metrics"]
        assert figures["vertices"] == len(vertices)
        assert figures["triangles"] == len(triangles)
        u, v = flat[triangles[:, 1]] - flat[triangles[:, 0]], flat[triangles[:, 2]] - flat[triangles[:, 0]]
        area = 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()
        assert figures["area_mm2"] == pytest.approx(area, rel=1e-12)
        assert figures["self_intersections_3d"] == 0
        assert figures["flipped_triangles"] == 0
        assert figures["boundary_error_mm"] == 0.0


@pytest.mark.parametrize("name", ["wrinkle", "boat", "shoe_2"])
def test_building_again_gives_the_same_files(built, name, tmp_path):
    """Placements are stored and used again, so that even the layout repeats; only the times differ."""
    out = shutil.copytree(built(name), tmp_path / "out")
    report = read_report(out)
    before = {name: (out / name).read_bytes() for name in report["files"] if name != "report.json"}
    assert main(["build", str(ROOT / "projects" / name / "project.yaml"), "-o", str(out)]) == 0
    assert {name: (out / name).read_bytes() for name in before} == before


def test_the_written_files_verify(out, tmp_path):
    assert main(["verify", str(shutil.copytree(out, tmp_path / "out"))]) == 0
