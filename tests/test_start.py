"""`flatnet faces` and `flatnet new`: what they find, and that what they write loads and builds."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from matplotlib.image import imread
from written import read_report

from flatnet import build, check
from flatnet.cli import main
from flatnet.project import ProjectError, load_project
from flatnet.start import DrawingOptions, faces


def obj(*curves):
    """An OBJ with one `l` a curve."""
    lines, count = [], 0
    for curve in curves:
        lines += [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in np.asarray(curve, float)]
        lines.append("l " + " ".join(str(count + i) for i in range(1, len(curve) + 1)))
        count += len(curve)
    return "\n".join(lines) + "\n"


def edges(corners, pairs):
    return [(corners[a], corners[b]) for a, b in pairs]


TETRAHEDRON = edges(
    50 * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]), [(a, b) for a in range(4) for b in range(a)]
)
CUBE = edges(
    50 * np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]),
    [(a, b) for a in range(8) for b in range(a) if bin(a ^ b).count("1") == 1],
)
CORNERS = [(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0)]
SQUARE = edges(CORNERS, [(0, 1), (1, 2), (2, 3), (3, 0)])
DIAGONALS = [[(0, 0, 0), (49, 49, 0), (100, 100, 0)], [(100, 0, 0), (49, 51, 0), (0, 100, 0)]]


def torus(across=8, around=6):
    def point(i, j):
        u, v = 2 * np.pi * i / across, 2 * np.pi * j / around
        r = 60 + 20 * np.cos(v)
        return r * np.cos(u), r * np.sin(u), 20 * np.sin(v)

    rings = [[point(i, j) for j in np.arange(0, around + 0.1, 0.5)] for i in range(across)]
    return rings + [[point(i, j) for i in np.arange(0, across + 0.1, 0.5)] for j in range(around)]


def circle(z):
    turns = np.linspace(0, 2 * np.pi, 25)
    return np.stack([30 * np.cos(turns), 30 * np.sin(turns), 0 * turns + z], axis=1)


def meridians(count):
    along = np.linspace(0, np.pi, 13)
    return [
        50 * np.stack([np.sin(along) * np.cos(t), np.sin(along) * np.sin(t), np.cos(along)], axis=1)
        for t in 2 * np.pi * np.arange(count) / count
    ]


HAIR = [[(50, 50, 50), (90, 90, 90)], [(0, 0, 50), (0, 0, 90)]]
JOINED = DrawingOptions(join_crossings=True)


@pytest.mark.parametrize(
    ("curves", "options", "patches", "openings", "warnings"),
    [
        (TETRAHEDRON, DrawingOptions(), 4, 0, []),
        (CUBE, DrawingOptions(), 6, 0, []),
        (torus(), DrawingOptions(), 48, 0, []),
        ([circle(0), circle(40)], DrawingOptions(), 2, 2, ["2 parts"]),
        (meridians(5), DrawingOptions(), 5, 0, []),
        ([*CUBE, *HAIR], DrawingOptions(), 6, 0, ["trimmed_end", "trimmed_end"]),
        ([*SQUARE, *DIAGONALS], JOINED, 4, 1, ["crossing_curves"]),
        (DIAGONALS[:1] + SQUARE, DrawingOptions(), 2, 1, []),
        (
            [np.array(c) + np.random.default_rng(k).uniform(0, 0.05, (2, 3)) for k, c in enumerate(CUBE)],
            DrawingOptions(snap="0.1"), 6, 0, ["snapped_end"] * 24,
        ),
    ],
    ids=["tetrahedron", "cube", "torus", "two loops", "meridians", "dead ends", "crossing", "diagonal", "loose ends"],
)  # fmt: skip
def test_faces_of_a_drawing(curves, options, patches, openings, warnings, tmp_path):
    (tmp_path / "net.obj").write_text(obj(*curves))
    started = faces(tmp_path / "net.obj", tmp_path / "net.yaml", options)
    found = [line for line in started.lines if line.startswith("warning")]
    assert len(found) == len(warnings) and all(word in line for word, line in zip(warnings, found))
    project, network = check(tmp_path / "net.yaml")
    assert (len(project.patches), len(project.openings)) == (patches, openings)
    assert network.face_count == patches + openings and not network.failed
    # the list is what is written
    text = (tmp_path / "net.yaml").read_text()
    assert all(line in text for line in started.lines if line.startswith("  face_"))


def test_crossing_curves_that_nobody_joins_are_named(tmp_path):
    (tmp_path / "net.obj").write_text(obj(*SQUARE, *DIAGONALS))
    lines = faces(tmp_path / "net.obj", tmp_path / "net.yaml").lines
    [warning] = [line for line in lines if line.startswith("warning")]
    assert "cross at (50, 50, 0)" in warning and "join: crossings" in warning


@pytest.mark.parametrize("curves", [TETRAHEDRON, [circle(0)], meridians(5)], ids=["tetrahedron", "disc", "meridians"])
def test_what_is_written_builds(curves, tmp_path, monkeypatch, capsys):
    (tmp_path / "my net.obj").write_text(obj(*curves))
    monkeypatch.chdir(tmp_path)
    assert main(["faces", "my net.obj", "--units", "mm", "--up", "y"]) == 0
    assert capsys.readouterr().out.split("\n")[-3:-1] == ["my net.yaml", "my net-faces.png"]
    with (tmp_path / "my net.yaml").open("a") as stream:
        stream.write("nesting: {seconds: 1}\n")
    result = build("my net.yaml", "out")
    assert result.exit_status == 0
    for patch in read_report(tmp_path / "out")["patches"]:
        assert patch["metrics"]["max_flattenability_rad"] <= 1e-9
    assert min(imread("my net-faces.png").shape[:2]) > 800


def test_faces_of_a_project(tmp_path, capsys):
    """All of them, what they are already, and the project file stays as it is."""
    (tmp_path / "net.obj").write_text(obj(*CUBE))
    faces(tmp_path / "net.obj", tmp_path / "net.yaml")
    text = (tmp_path / "net.yaml").read_text()
    lines = text.split("\n")
    kept = "\n".join(line for line in lines if "face_2:" not in line).replace("face_3:", "lid:")
    (tmp_path / "net.yaml").write_text(kept)
    assert main(["faces", str(tmp_path / "net.yaml"), "-o", str(tmp_path / "picture.png")]) == 0
    out = capsys.readouterr().out
    listed, free = out.split("patches:\n")
    assert listed.startswith("patches, listed:\n") and listed.count("around:") == 5 and "  lid: {around" in listed
    [missing] = [line for line in lines if "face_2:" in line]
    assert free.split("\n")[0].split(": ", 1)[1] == missing.split(": ", 1)[1]
    assert (tmp_path / "net.yaml").read_text() == kept and (tmp_path / "picture.png").exists()


def test_the_picture_is_the_same_each_time(tmp_path):
    (tmp_path / "net.obj").write_text(obj(*CUBE))
    for name in ("one", "two"):
        faces(tmp_path / "net.obj", tmp_path / f"{name}.yaml")
    assert (tmp_path / "one-faces.png").read_bytes() == (tmp_path / "two-faces.png").read_bytes()


def test_dense_points_become_splines_unless_they_have_corners(tmp_path):
    (tmp_path / "net.obj").write_text(obj(*(np.linspace(a, b, 200) for a, b in CUBE)))
    faces(tmp_path / "net.obj", tmp_path / "net.yaml")
    assert {curve.kind for curve in load_project(tmp_path / "net.yaml").curves.values()} == {"spline"}
    zigzag = [[(k, k % 2, 0) for k in range(200)], [(0, 0, 0), (0, 50, 0), (199, 50, 0), (199, 1, 0)]]
    (tmp_path / "zigzag.obj").write_text(obj(*zigzag))
    faces(tmp_path / "zigzag.obj", tmp_path / "zigzag.yaml")
    assert {curve.kind for curve in load_project(tmp_path / "zigzag.yaml").curves.values()} == {"polyline"}


def test_a_first_example(tmp_path, capsys):
    assert main(["new", str(tmp_path / "first.yaml")]) == 0
    assert capsys.readouterr().out.split("\n")[0] == "patches, listed:"
    assert build(tmp_path / "first.yaml", tmp_path / "out").exit_status == 0


@pytest.mark.parametrize(
    "mesh",
    [trimesh.creation.icosphere(3, 0.1), trimesh.creation.box((0.2, 0.3, 0.1)), trimesh.creation.cylinder(0.05, 0.4)],
    ids=["ball", "box", "cylinder"],
)
def test_a_patch_on_a_mesh(mesh, tmp_path):
    mesh.export(tmp_path / "last.stl")
    file = tmp_path / "sub" / "first.yaml"
    file.parent.mkdir()
    assert main(["new", str(file), "--mesh", str(tmp_path / "last.stl"), "--units", "m"]) == 0
    result = build(file, tmp_path / "out")
    assert result.exit_status == 0
    [patch] = result.report["patches"]
    assert patch["metrics"]["surface_distance_mm"]["max"] < 1.05  # its half diagonal's sagitta on the ball: 1 mm


STATUE = Path(__file__).parents[1] / "projects" / "moai" / "statue.obj"


def test_a_patch_on_a_figure_lies_where_it_is_smooth_and_nothing_alarms(tmp_path, capsys):
    """The middles of its box's sides lie far off it, at arms and folds."""
    file = tmp_path / "first.yaml"
    assert main(["new", str(file), "--mesh", str(STATUE)]) == 0
    lines = capsys.readouterr().out.split("\n")
    assert lines[0] == "mesh: 1557 x 1022 x 4000 mm, 10630 triangles"
    assert lines[1] == "patches, listed:" and lines[2].startswith("  first: {around: [one, two, three, four]}")
    assert lines[3:] == ["statue: 1 face", str(file), str(tmp_path / "first-faces.png"), ""]
    result = build(file, tmp_path / "out", workers=1)
    assert result.exit_status == 0
    [patch] = result.report["patches"]
    # An arc whose ends turn by 50 degrees rises tan 25 degrees times half its chord, here half of 4000 mm / 10 sqrt 2.
    assert patch["metrics"]["surface_distance_mm"]["max"] < 200.0 * np.sqrt(2.0) * np.tan(np.radians(25.0))


def test_where_edges_belong_to_three_faces_the_curves_are_projected(tmp_path):
    box = trimesh.creation.box((200, 300, 100))
    fin = trimesh.Trimesh([*box.vertices[box.edges[0]], (0, 0, 300)], [[0, 1, 2]])
    trimesh.util.concatenate([box, fin]).export(tmp_path / "box.stl")
    assert main(["new", str(tmp_path / "first.yaml"), "--mesh", str(tmp_path / "box.stl")]) == 0
    assert "geodesic" not in (tmp_path / "first.yaml").read_text()
    assert not check(tmp_path / "first.yaml")[1].failed


def test_a_mesh_without_a_smooth_place_gets_no_patch(tmp_path, capsys):
    """Triangles in all directions that hang together nowhere."""
    random = np.random.default_rng(0)
    corners = np.repeat(random.normal(0.0, 100.0, (40, 3)), 3, axis=0) + random.normal(0.0, 2.0, (120, 3))
    trimesh.Trimesh(corners, np.arange(120).reshape(40, 3)).export(tmp_path / "shreds.stl")
    file = tmp_path / "first.yaml"
    assert main(["new", str(file), "--mesh", str(tmp_path / "shreds.stl")]) == 0
    assert "no smooth place for a first patch was found: draw curves on the mesh" in capsys.readouterr().out
    # Curves are all that is missing.
    with pytest.raises(ProjectError, match="curves"):
        check(file)
    file.write_text(file.read_text() + "curves: {a: {points: [[0, 0, 0], [50, 0, 0], [0, 50, 0]], closed: true}}\n")
    assert load_project(file).surface is not None


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("faces net.obj", "net.yaml: exists already"),
        ("faces net.obj -o net.txt", "net.txt: a project file ends in .yaml"),
        ("faces net.obj -o nowhere/net.yaml", "there is no folder 'nowhere'"),
        ("faces net.obj --units furlong -o other.yaml", "other.yaml:6:10: import: units: expected mm, cm"),
        ("faces nothing.obj", "nothing.yaml:5:9: import: file: there is no file"),
        ("faces empty.obj", "empty.obj: has no curves"),
        ("faces hair.obj", "hair.yaml:4:1: import: nothing is left of its curves"),
        ("faces nothing.yaml", "there is no such file"),
        ("new net.yaml", "net.yaml: exists already"),
        ("new other.yaml --mesh nothing.stl", "other.yaml:4:9: surface: mesh: there is no file"),
        ("new other.yaml --mesh net.obj", "has no faces"),
    ],
)
def test_what_is_refused(command, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "net.obj").write_text(obj(*CUBE))
    (tmp_path / "hair.obj").write_text(obj(*HAIR))
    (tmp_path / "empty.obj").write_text("v 0 0 0\n")
    (tmp_path / "net.yaml").write_text("mine")
    before = sorted(tmp_path.iterdir())
    assert main(command.split()) == 2
    assert message in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before and (tmp_path / "net.yaml").read_text() == "mine"


def test_without_matplotlib_there_is_no_picture_and_all_else(tmp_path):
    (tmp_path / "net.obj").write_text(obj(*CUBE))
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from flatnet.cli import main; sys.exit(main(['faces', 'net.obj']))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0
    assert "no picture: drawing needs matplotlib" in done.stdout
    assert len(load_project(tmp_path / "net.yaml").patches) == 6
