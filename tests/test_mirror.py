"""Mirror images: exact in space and in the plane, sharing what lies in the mirror plane, told when they can't be."""

import numpy as np
import pytest
import shapely
import yaml
from failure_cases import beside
from written import read_obj, read_report

from flatnet.cli import main
from flatnet.fitting.mirror import reflect_patch
from flatnet.fitting.run import run_patch
from flatnet.geometry.triangles import signed_areas
from flatnet.network.assembly import make_network
from flatnet.pattern.piece import make_piece
from flatnet.pattern.seams import plan_seams
from flatnet.project import ProjectError, load_project
from flatnet.report.metrics import normal_deviations

IDENTITY = np.eye(3)


def tent(frame=IDENTITY, shift=(0.0, 0.0, 0.0), **changes):
    """Half a tent and its mirror image, which share its ridge; turned and moved."""

    def moved(point):
        return (frame @ np.array(point, float) + shift).tolist()

    def turned(normal):
        return (frame @ np.array(normal, float)).tolist()

    def curve(start, end, middle, normal):
        return {"kind": "spline", "from": start, "to": end, "points": [moved(middle)], "normals": turned(normal)}

    places = {"top": [0, 0, 40], "back": [0, 120, 60], "low": [90, 0, 0], "far": [80, 130, 5]}
    return {
        "flatnet": 1,
        "name": "tent",
        "edge_length": 12,
        "mirror": {"point": moved([0, 0, 0]), "normal": turned([1, 0, 0])},
        "nodes": {name: moved(place) for name, place in places.items()}
        | {"low_left": {"mirror_of": "low"}, "far_left": {"mirror_of": "far"}},
        "curves": {
            "ridge": curve("top", "back", [0, 60, 58], [0, -0.2, 1]),
            "front": curve("top", "low", [50, -10, 28], [0.4, 0, 1]),
            "side": curve("low", "far", [95, 60, 8], [1, 0, 0.6]),
            "rear": curve("far", "back", [45, 128, 45], [0.5, 0.2, 1]),
            "front_left": {"mirror_of": "front"},
            "side_left": {"mirror_of": "side"},
            "rear_left": {"mirror_of": "rear"},
        },
        "patches": {"left": {"mirror_of": "right"}, "right": {"around": ["front", "side", "rear", "-ridge"]}},
        "rest": "openings",
        "materials": {"cloth": {"width": 500, "allowance": 7}},
        "nesting": {"seconds": 1},
        **changes,
    }


def loaded(folder, content):
    (folder / "project.yaml").write_text(yaml.safe_dump(content))
    return load_project(folder / "project.yaml")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The project and its network, both patches fitted: the left one reflected."""
    project = loaded(tmp_path_factory.mktemp("tent"), tent())
    network = make_network(project, None)
    left, right = network.patches
    fitted = run_patch(right, project.patches["right"].fitting)
    return project, network, reflect_patch(fitted, left, project.mirror), fitted


X = np.array([-1.0, 1.0, 1.0])
Y = np.array([1.0, -1.0])


def backwards(values):
    """Boundary vertices from the same one on, the other way round."""
    return np.roll(values[::-1], 1, axis=0)


def test_the_network_of_both_sides_is_symmetric_to_the_last_bit(made):
    _, network, _, _ = made
    left, right = network.patches
    assert np.array_equal(left.boundary.vertices, backwards(right.boundary.vertices) * X)
    # Edge i of the image runs along edge -1 - i of the original.
    assert np.array_equal(left.boundary.normals, right.boundary.normals[::-1] * X)
    ridge = network.stretches["ridge"]
    assert (ridge.vertices[:, 0] == 0).all() and (ridge.left_normals[:, 0] == 0).all()
    assert [(s.seam, s.reversed) for s in left.boundary.stretches] == [
        ("ridge", False), ("rear_left", True), ("side_left", True), ("front_left", True),
    ]  # fmt: skip
    front, image = network.stretches["front"], network.stretches["front_left"]
    assert (image.start, image.end) == ("top", "low_left")
    assert np.array_equal(image.left_normals, front.right_normals * X)


def test_at_a_crease_the_sides_change_places(tmp_path):
    content = tent()
    content["curves"]["front"]["normals"] = {"left": [0.4, 0, 1], "right": [0, -1, 0.1]}
    content["curves"]["ridge"]["normals"] = {"left": [0, 0, 1], "right": [0.5, 0, 1]}
    stretches = make_network(loaded(tmp_path, content), None).stretches
    front, image, ridge = stretches["front"], stretches["front_left"], stretches["ridge"]
    assert np.array_equal(image.left_normals, front.right_normals * X)
    assert np.array_equal(image.right_normals, front.left_normals * X)
    # The original lies on the right of the ridge: its normals are kept, those on the left are their images.
    assert (ridge.right_normals[:, 0] > 0.4).all()
    assert np.array_equal(ridge.left_normals, ridge.right_normals * X)


def test_the_image_is_exact_in_space_and_in_the_plane(made):
    _, _, left, right = made
    n = right.mesh.boundary_count
    assert np.array_equal(left.mesh.vertices[n:], right.mesh.vertices[n:] * X)
    assert np.array_equal(left.mesh.vertices[:n], backwards(right.mesh.vertices[:n]) * X)
    assert np.array_equal(left.flat[n:], right.flat[n:] * Y)
    assert np.array_equal(left.outline, backwards(right.outline) * Y)
    assert len(left.mesh.triangles) == len(right.mesh.triangles)
    assert left.mesh.max_flattenability == pytest.approx(right.mesh.max_flattenability, abs=1e-12)


def test_the_image_is_anticlockwise_and_its_normals_point_outside(made):
    _, _, left, right = made
    assert (signed_areas(left.flat, left.mesh.triangles) > 0).all()
    assert (signed_areas(left.planar.positions, left.planar.triangles) > 0).all()
    np.testing.assert_allclose(normal_deviations(left), normal_deviations(right)[::-1], atol=1e-12)
    np.testing.assert_allclose(
        left.planar_boundary.inner_angles, backwards(right.planar_boundary.inner_angles), atol=0
    )


def test_cut_lines_and_notches_are_mirror_images(made, tmp_path):
    _, network, left, right = made
    content = tent()
    content["curves"]["side"] |= {"allowance": {"left": 12, "right": 3}, "notches": {"at": [20, "70%"]}}
    project = loaded(tmp_path, content)
    seams = plan_seams(project, network)
    assert (seams["side_left"].spec.left, seams["side_left"].spec.right) == (3, 12)  # left is on the other side
    one, other = (make_piece(fitted, project.materials["cloth"], seams) for fitted in (left, right))
    lines = (shapely.LinearRing(one.cut_line), shapely.LinearRing(other.cut_line * Y))
    assert shapely.hausdorff_distance(*lines) <= 1e-9
    assert len(one.notches) == len(other.notches) == 2
    feet = [sorted(notch.foot.round(6).tolist() for notch in piece.notches) for piece in (one, other)]
    assert feet[0] == sorted([x, -y] for x, y in feet[1])


def test_written_files_are_exact_and_the_seam_in_the_plane_is_one(tmp_path):
    loaded(tmp_path, tent())
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 0
    report = read_report(tmp_path / "out")
    assert [patch["name"] for patch in report["patches"]] == ["left", "right"]
    left, right = (read_obj(tmp_path / "out" / "patches" / f"{name}.obj") for name in ("left", "right"))
    for one, other, flip in ((left[0], right[0], X), (left[1], right[1], Y)):
        assert {tuple(row) for row in one + 0.0} == {tuple(row) for row in other * flip + 0.0}
    ridge = next(seam for seam in report["seams"] if seam["curve"] == "ridge")
    assert sorted(ridge["patches"]) == ["left", "right"]
    assert ridge["difference_mm"] <= 1e-9
    by_name = {"left": left, "right": right}
    a, b = (by_name[side["patch"]][0][side["vertices"]] for side in ridge["sides"])
    assert np.array_equal(a, b)
    image = report["patches"][0]["method"]
    assert (image["name"], image["status"]) == ("mirror", "the mirror image of 'right'")


def test_a_slanted_plane_closes_all_boundaries_too(tmp_path):
    frame = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    frame *= np.linalg.det(frame)
    project = loaded(tmp_path, tent(frame, shift=np.array([300.0, -70.0, 11.0])))
    network = make_network(project, None)
    left, right = network.patches
    assert not network.failed
    image = project.mirror.reflect(right.boundary.vertices)
    np.testing.assert_allclose(left.boundary.vertices, backwards(image), atol=1e-10)
    for name in ("top", "back"):
        assert abs(project.mirror.heights(network.nodes[name])) <= 1e-12 * 300


def test_what_lies_nearly_in_the_plane_is_put_into_it(tmp_path):
    content = tent()
    content["nodes"]["top"] = [0.3, 0, 40]
    content["curves"]["ridge"]["points"] = [[-0.2, 60, 58]]
    network = make_network(loaded(tmp_path, content), None)
    assert (network.stretches["ridge"].vertices[:, 0] == 0).all()
    assert (network.stretches["front"].vertices[0] == network.nodes["top"]).all()


def test_a_node_at_a_fraction_of_a_curve_has_an_image_on_its_image(tmp_path):
    content = tent()
    content["nodes"] |= {"mid": {"at": {"curve": "side", "t": 0.4}}, "mid_left": {"mirror_of": "mid"}}
    content["curves"]["dart"] = {"from": "mid", "to": "tip", "slit": True, "normals": [0.5, 0, 1]}
    content["curves"]["dart_left"] = {"mirror_of": "dart"}
    content["nodes"] |= {"tip": [50, 50, 38], "tip_left": {"mirror_of": "tip"}}
    around = ["front", "side:low..mid", "dart", "-dart", "side:mid..far", "rear", "-ridge"]
    content["patches"]["right"]["around"] = around
    network = make_network(loaded(tmp_path, content), None)
    left, right = network.patches
    assert np.array_equal(left.boundary.vertices, backwards(right.boundary.vertices) * X)
    assert "side_left:mid_left..far_left" in network.stretches
    n = len(left.boundary.vertices)
    assert left.boundary.slit_tips == tuple(n - tip for tip in right.boundary.slit_tips)


def test_an_original_is_not_drawn_through_an_image(tmp_path):
    content = tent()
    content["curves"]["belt"] = {"from": "low_left", "to": "far", "normals": [0, 0, 1]}
    assert "'belt': is drawn through 'low_left', a mirror image" in refused(tmp_path, content)


def refused(folder, content):
    with pytest.raises(ProjectError) as caught:
        make_network(loaded(folder, content), None)
    return str(caught.value)


def test_a_node_off_the_plane_needs_an_image(tmp_path):
    content = tent()
    content["nodes"]["top"] = [4, 0, 40]
    said = refused(tmp_path, content)
    assert "needs the image of node 'top', which is 4.00 mm off the mirror plane" in said
    assert "top_2: {mirror_of: top}" in said


def test_a_curve_between_both_sides_has_to_lie_in_the_plane(tmp_path):
    content = tent()
    content["curves"]["ridge"]["points"] = [[5, 60, 58]]
    assert "'ridge' bounds a patch that is mirrored" in refused(tmp_path, content)
    content = tent()
    content["curves"]["ridge"]["normals"] = [1, 0, 0.1]
    assert "point out of it by more than 60 degrees" in refused(tmp_path, content)


@pytest.mark.parametrize(
    "section, name, entry, said",
    [
        ("nodes", "low_left", {"mirror_of": "lwo"}, "there is no node 'lwo'; did you mean 'low'?"),
        ("curves", "front_left", {"mirror_of": "side_left"}, "'side_left' is an image itself"),
        ("curves", "front_left", {"mirror_of": "side"}, "'side' has the image 'front_left' already"),
        ("curves", "front_left", {"mirror_of": "front", "kind": "spline"}, "unknown key 'kind'"),
        ("patches", "left", {"mirror_of": "rihgt"}, "did you mean 'right'?"),
    ],
)
def test_images_of_nothing(tmp_path, section, name, entry, said):
    content = tent()
    content[section][name] = entry
    assert said in refused(tmp_path, content)


def test_images_need_a_plane(tmp_path):
    content = tent()
    del content["mirror"]
    assert "mirror_of, but the file has no mirror; add `mirror: {normal: ...}`" in refused(tmp_path, content)


@pytest.mark.parametrize("x, warned", [(0.0, False), (5.0, True)])
def test_an_image_is_not_blamed_for_what_its_original_leaves_the_surface_by(tmp_path, x, warned):
    """The rim hangs 12 mm off the ball, as a skirt hangs off its legs."""
    content = beside(tmp_path, x)
    content["curves"]["rim"] = {
        "kind": "spline", "from": "front", "to": "back", "points": [[37, 0, 49.6]], "normals": [0.6, 0, 0.8],
    }
    loaded(tmp_path, content)
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 0
    left, _ = read_report(tmp_path / "out")["patches"]
    assert left["metrics"]["surface_distance_mm"]["max_outside"] > 8.0
    assert ("off_surface" in [warning["code"] for warning in left["warnings"]]) == warned


def test_the_image_of_what_can_not_be_made_fails_with_it(tmp_path):
    content = tent()
    content["patches"]["right"]["min_angle"] = dict.fromkeys(["top", "low", "far", "back"], 130)
    loaded(tmp_path, content)
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 1
    left, right = read_report(tmp_path / "out")["patches"]
    assert left["failure"]["code"] == right["failure"]["code"] == "lemma_2"
    assert "as the mirror image of 'right'" in left["failure"]["message"]


@pytest.mark.parametrize("x, warned", [(0.0, False), (5.0, True)])
def test_an_image_that_leaves_a_surface_with_unequal_halves_is_warned_of(tmp_path, x, warned):
    loaded(tmp_path, beside(tmp_path, x))
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 0
    left, right = read_report(tmp_path / "out")["patches"]
    codes = [warning["code"] for warning in left["warnings"]]
    assert ("off_surface" in codes) == warned
    assert "off_surface" not in [warning["code"] for warning in right["warnings"]]
    if warned:
        (warning,) = [warning for warning in left["warnings"] if warning["code"] == "off_surface"]
        assert "'rim_left' at " in warning["where"] and warning["amount"] > 4
