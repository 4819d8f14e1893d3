"""`import` and `points: FILE` in a project file."""

from textwrap import dedent

import numpy as np
import pytest
import trimesh

from flatnet.build import check
from flatnet.forms import make_surface
from flatnet.network.listing import list_faces
from flatnet.project import ProjectError, load_project

HEAD = "flatnet: 1\nname: imported\nedge_length: 10\n"
SQUARE = """\
curve,x,y,z
south,0,0,0
south,10,0,0
east,10,0,0
east,10,10,0
north,10,10,0.02
north,0,10,0
west,0,10,0
west,0,0,0
"""
ALL = "patches: {top: {around: [south, east, north, west]}}\nrest: openings\n"


@pytest.fixture
def load(tmp_path):
    (tmp_path / "square.csv").write_text(SQUARE)
    (tmp_path / "big.csv").write_text("0,0,0\n1e4,0,0\n")
    (tmp_path / "arc.csv").write_text("0,0,0\n5,-2,0\n10,0,0\n")

    def load(text, head=HEAD):
        file = tmp_path / "project.yaml"
        file.write_text(head + dedent(text))
        return load_project(file)

    return load


def test_a_network_from_a_drawing(load):
    project = load("import: {file: square.csv, snap: 0.1, normals: curves}\n" + ALL)
    assert list(project.nodes) == ["n1", "n2", "n3", "n4"]
    assert list(project.curves) == ["south", "east", "north", "west"]
    assert [f.code for f in project.findings] == ["snapped_end"] * 2
    np.testing.assert_array_equal(project.nodes["n3"].position, [10, 10, 0.01])
    _, network = check(project.file)
    assert [patch.name for patch in network.patches] == ["top"]


def test_units_and_place(load):
    place = "place: {origin: [1, 2, 3], x: [0, 2, 0], y: [0, 0, 1]}"
    project = load(f"import: {{file: square.csv, units: cm, snap: 1, {place}}}")
    corners = [node.position.tolist() for node in project.nodes.values()]
    np.testing.assert_allclose(corners, [[1, 2, 3], [1, 102, 3], [1.1, 102, 103], [1, 2, 103]], atol=1e-12)
    project = load("import: {file: square.csv, up: y, snap: 1}")
    corners = [node.position.tolist() for node in project.nodes.values()]
    np.testing.assert_allclose(corners, [[0, 0, 0], [10, 0, 0], [10, -0.01, 10], [0, 0, 10]], atol=1e-12)


def test_what_an_import_says_of_its_curves_and_what_a_curve_says_of_itself(load):
    project = load("""
        import: {file: square.csv, snap: 1, kind: spline, normals: curves, edge_length: 2}
        curves:
          east: {normals: [0, 0, 1], edge_length: 3, kind: polyline}
          strap: {from: n1, to: n3, normals: curves}
        """)
    curves = project.curves
    assert {name: c.edge_length for name, c in curves.items()} == {
        "south": 2.0, "east": 3.0, "north": 2.0, "west": 2.0, "strap": 10.0,
    }
    assert [c.normals.source for c in curves.values()] == ["curves", "given", "curves", "curves", "curves"]
    assert [c.kind for c in curves.values()] == ["spline", "polyline", "spline", "spline", "polyline"]


def test_two_imports_with_prefixes(load):
    project = load("import: [{file: square.csv, snap: 1, prefix: a}, {file: square.csv, snap: 1, prefix: b}]")
    assert list(project.curves) == ["asouth", "aeast", "anorth", "awest", "bsouth", "beast", "bnorth", "bwest"]


def test_several_files_are_one_network(load, tmp_path):
    (tmp_path / "lid.csv").write_text("10,10,0.02\n5,5,5\n0,0,0\n")
    project = load("import: {file: [square.csv, lid.csv], snap: 1, normals: curves}")
    assert project.curves["lid"].nodes == ["n3", "n1"]


def test_points_from_a_file(load):
    project = load("""
        nodes: {a: [0, 0, 0], b: [10, 0, 0]}
        curves: {arc: {from: a, points: arc.csv, to: b}, ring: {points: arc.csv}}
        """)
    assert [np.asarray(p).tolist() for p in project.curves["arc"].points] == [[5, -2, 0]]
    assert len(project.curves["ring"].points) == 3 and project.curves["ring"].closed


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import: {snap: 1}", "4:1: import: 'file' is missing"),
        ("import: {file: nothing.csv}", "4:16: import: file: there is no file"),
        ("import: {file: square.csv, snapp: 1}", "4:28: import: unknown key 'snapp'; did you mean 'snap'"),
        ("import: {file: project.yaml}", "4:16: import: file: .*: a drawing ends in"),
        ("import: {file: [square.csv, [1]]}", "4:29: import: file, item 2: expected the path of a drawing"),
        ("import: [{file: square.csv}, {file: square.csv}]", "4:30: import, item 2: another import has a curve 'so"),
        ("import: {file: square.csv, join: yes}", "4:34: import: join: expected 'crossings'"),
        ("import: {file: square.csv, snap: -1}", "4:34: import: snap: must not be less than 0"),
        ("import: {file: square.csv, up: y, place: {x: [1, 0, 0], y: [0, 1, 0]}}", "'up' and 'place' exclude"),
        ("import: {file: square.csv, place: {x: [1, 0, 0]}}", "4:28: import: place: 'y' is missing"),
        ("import: {file: square.csv, place: {x: [1, 0, 0], y: [1, 1, 0]}}", "right angle, got 45 degrees"),
        ("import: {file: big.csv, units: 1e6}", "a point of it is 1e\\+10 mm away; is the unit right"),
        ("import: {file: arc.csv, trim: true}", "4:1: import: nothing is left of its curves"),
        ("import: {file: square.csv, on: surface}", "on: surface, but the file has no surface"),
        ("import: {file: square.csv, normals: surface}", "normals: surface, but the file has no surface"),
        ("import: square.csv", "4:9: import: expected keys with values"),
        ("import: {file: square.csv, snap: 1}\ncurves: {east: {from: n1}}", "5:17: curve 'east': unknown key 'from'"),
        ("import: {file: square.csv, snap: 1}\nnodes: {n1: [5, 5, 5]}", "5:9: nodes: 'n1' is a node of an import too"),
        ("import: {file: square.csv, snap: 1}\nnodes: {b: [0, 0, 0]}", "5:9: nodes: 'b' is at the same place as 'n1'"),
        ("curves: {a: {points: square.csv}}", "4:22: curve 'a': points: .*square.csv has 4 curves, and one is wanted"),
        ("curves: {a: {points: nothing.csv}}", "4:22: curve 'a': points: there is no file"),
    ],
)
def test_bad_imports(text, message, load):
    with pytest.raises(ProjectError, match=message):
        load(text)



# --- onto a surface

PAGE = """<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
<circle id="rim" cx="20" cy="20" r="12"/><path id="cut" d="M 2 20 H 38"/></svg>"""


@pytest.fixture
def ball(tmp_path):
    """A ball of radius 50 and a page with a circle and a line through it."""
    pytest.importorskip("svgelements")
    trimesh.creation.icosphere(4, 50.0).export(tmp_path / "ball.stl")
    (tmp_path / "page.svg").write_text(PAGE)

    def load(imported):
        file = tmp_path / "project.yaml"
        lines = ["flatnet: 1", "name: ball", "edge_length: 3", "surface: {mesh: ball.stl}"]
        file.write_text("\n".join([*lines, f"import: {{file: page.svg, join: crossings, trim: true, {imported}}}"]))
        return load_project(file)

    return load


def test_a_page_cast_onto_a_ball(ball):
    """The page stands above the ball, its middle over the top; what is cast keeps its x and y."""
    project = ball("place: {origin: [-20, 20, 80], x: [1, 0, 0], y: [0, 1, 0]}, cast: [0, 0, -1]")
    listed = list_faces(project, make_surface(project))
    assert len(listed.faces) == 3  # two halves and what is around them
    x, y, z = np.concatenate([s.vertices for s in listed.stretches.values() if s.curve != "cut"]).T
    np.testing.assert_allclose(np.hypot(x, y), 12.0, atol=0.02)  # a chord between cast points: 1.5^2 / (8 * 12)
    np.testing.assert_allclose(z, np.sqrt(50**2 - 12**2), atol=0.15)  # the mesh of the ball lies inside it


def test_the_nearest_points_lie_on_the_lines_to_the_centre(ball):
    project = ball("place: {origin: [-20, 20, 80], x: [1, 0, 0], y: [0, 1, 0]}, on: surface")
    listed = list_faces(project, make_surface(project))
    x, y, _ = np.concatenate([s.vertices for s in listed.stretches.values() if s.curve != "cut"]).T
    # seen from 31 mm above, a facet that leans by 0.04 rad moves its nearest point by 1.2 mm
    np.testing.assert_allclose(np.hypot(x, y), 50 * 12 / np.hypot(12, 80), atol=1.2)


def test_a_cast_that_misses_is_named(ball):
    project = ball("place: {origin: [-20, 20, 80], x: [1, 0, 0], y: [0, 1, 0]}, cast: [0, 0, 1]")
    with pytest.raises(ProjectError, match=r"node 'n\d' at \(.*, 80.0\), cast along its direction misses the surface"):
        list_faces(project, make_surface(project))


def test_a_cast_needs_a_surface(load):
    with pytest.raises(ProjectError, match="4:28: import: cast, but the file has no surface"):
        load("import: {file: square.csv, cast: [0, 0, 1]}")
