"""`flatnet draw`: a PNG of a build's written files, or one line that says why not."""

import io
import json
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
import shapely
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imread
from pieces import cloth, piece

from flatnet.cli import main
from flatnet.export.drawn_layout import DrawnPiece, read_layout
from flatnet.export.obj import write_obj
from flatnet.export.svg import write_layout
from flatnet.nesting import Layout, Placement
from flatnet.report.contact_sheet import (
    CAPTION,
    GAP,
    MARGIN,
    RESOLUTION,
    TALLEST_ROW,
    WIDTH,
    break_rows,
    fitted_caption,
)
from flatnet.report.panels import _name

OUTLINE = np.array([[0, 0], [200, 0], [200, 150], [0, 150]], float)
FAN = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])

PROJECT = """
flatnet: 1
name: plate
edge_length: 25
nodes: {a: [0, 0, 0], b: [200, 0, 0], c: [200, 100, 0], d: [0, 100, 0], e: [400, 0, 0], f: [400, 100, 0]}
curves:
  front: {from: a, to: e, points: [b], normals: [0, 0, 1]}
  middle: {from: b, to: c, normals: [0, 0, 1]}
  back: {from: f, to: d, points: [c], normals: [0, 0, 1]}
  left: {from: d, to: a, normals: [0, 0, 1]}
  right: {from: e, to: f, normals: [0, 0, 1]}
patches:
  west: {around: [front, middle, back, left]}
  east: {around: [front, right, back, -middle], mirrored: 1}
rest: openings
nesting: {seconds: 1}
"""


def tent(height):
    """A rectangle in space whose centre is raised: not flattenable unless the height is 0."""
    return np.column_stack([np.vstack([OUTLINE, [[100, 75]]]), [0, 0, 0, 0, height]])


def write_build(folder, warped_height=60.0, fitted_height=0.0, project="tent", **report):
    """A build of one patch and one that failed, as its files."""
    (folder / "patches").mkdir(parents=True)
    flat = tent(0.0)[:, :2]
    write_obj(folder / "patches" / "tent.obj", tent(fitted_height), FAN, flat)
    write_obj(folder / "patches" / "tent.initial.obj", tent(warped_height), FAN, flat)
    made = piece(OUTLINE, cloth(allowance=6.0), name="tent")
    layout = Layout(cloth(), (Placement(made, 1, False, 90.0, 170.0, 20.0),))
    write_layout(folder / "layout-cloth.svg", layout, project)
    ring = np.vstack([tent(0.0)[:4], tent(0.0)[:1]]).tolist()
    up, across = [[0, 0, 1]] * 4, [[1, 0, 0]] * 4
    curve = {"name": "rim", "curve": "rim", "vertices": ring, "normals": up, "right_normals": across}
    network = {"format": "flatnet-network/1", "nodes": {}, "curves": [curve]}
    (folder / "network.json").write_text(json.dumps(network))
    sheet = {"file": "layout-cloth.svg", "material": "cloth", "sheet_width_mm": 500.0, "draft": False}
    sheet |= {"used_length_mm": layout.used_length, "utilisation": layout.utilisation}
    content = {
        "format": "flatnet-report/1",
        "project": project,
        "patches": [{"name": "tent", "status": "ok"}, {"name": "lost", "status": "failed"}],
        "layouts": [sheet],
        "files": sorted(str(file.relative_to(folder)) for file in folder.rglob("*.*")),
    }
    (folder / "report.json").write_text(json.dumps({**content, **report}))
    return folder


def drawn(folder, picture):
    """(height, width, 3), 0 to 1."""
    assert main(["draw", str(folder), "-o", str(picture)]) == 0
    return imread(picture)[..., :3]


def part(pixels, low, high):
    """Part of the picture whose colours lie between two, inclusive."""
    return ((pixels >= np.array(low) - 1e-3) & (pixels <= np.array(high) + 1e-3)).all(axis=-1).mean()


def test_a_build_becomes_a_png_beside_its_folder(tmp_path, monkeypatch, capsys):
    (tmp_path / "plate.yaml").write_text(PROJECT)
    monkeypatch.chdir(tmp_path)
    assert main(["build", "plate.yaml", "-o", "out/plate"]) == 0
    before = sorted((tmp_path / "out" / "plate").rglob("*"))
    capsys.readouterr()
    assert main(["draw", "out/plate"]) == 0
    picture = tmp_path / "out" / "plate.png"
    assert capsys.readouterr().out == f"{picture}\n"
    assert sorted((tmp_path / "out" / "plate").rglob("*")) == before
    pixels = imread(picture)
    assert pixels.shape[1] == round(WIDTH * RESOLUTION) and 600 < pixels.shape[0] < 3000
    assert len(read_layout(tmp_path / "out" / "plate" / "layout-default.svg")) == 3


def test_red_where_not_flattenable_and_blue_where_it_is(tmp_path):
    """Flat, the tent is blue in two panels, raised in M^0 red in one of them, raised in both red in both."""
    heights = {"flat": (0.0, 0.0), "warped": (60.0, 0.0), "both": (60.0, 60.0)}
    pixels = {n: drawn(write_build(tmp_path / n, *h), tmp_path / f"{n}.png") for n, h in heights.items()}
    red = {name: part(p, [0.45, 0.0, 0.05], [0.82, 0.07, 0.2]) for name, p in pixels.items()}
    blue = {name: part(p, [0.09, 0.18, 0.4], [0.18, 0.34, 0.76]) for name, p in pixels.items()}
    assert red["flat"] < 0.005 and blue["flat"] > 0.08
    assert red["warped"] > 0.04 and blue["warped"] > 0.04
    assert red["both"] > 1.6 * red["warped"] and blue["both"] < 0.005


def test_the_same_build_gives_the_same_bytes_under_any_settings(tmp_path):
    folder = write_build(tmp_path / "out")
    drawn(folder, tmp_path / "a.png")
    with matplotlib.rc_context({"font.size": 30, "text.color": "red", "savefig.bbox": "tight"}):
        drawn(folder, tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.parametrize("project", ["a $\\frac$ of it", "x" * 200])
def test_names_are_text_and_no_formula(tmp_path, project):
    """A name read as a formula would end in an error; `drawn` asserts that there is none."""
    drawn(write_build(tmp_path / "out", project=project), tmp_path / "a.png")


def test_a_build_without_patches_shows_its_network(tmp_path):
    files = ["network.json", "report.json"]
    failed = [{"name": "lost", "status": "failed"}]
    folder = write_build(tmp_path / "out", patches=failed, layouts=[], files=files)
    pixels = drawn(folder, tmp_path / "a.png")
    assert 0.001 < (pixels < 0.5).all(axis=-1).mean() < 0.2


@pytest.mark.parametrize("mirrored", [False, True])
def test_pieces_are_read_as_they_are_drawn(tmp_path, mirrored):
    """y mirrored or not, turned by 30 degrees, moved, and y down from the sheet's upper edge, 500 mm up."""
    made = piece(OUTLINE, cloth(allowance=6.0), name="panel")
    layout = Layout(cloth(), (Placement(made, 1, mirrored, 30.0, 170.0, 20.0),))
    write_layout(tmp_path / "l.svg", layout, "x")
    (found,) = read_layout(tmp_path / "l.svg")
    z = OUTLINE @ [1.0, -1j if mirrored else 1j] * np.exp(1j * np.pi / 6.0) + (170.0 + 20.0j)
    on_page = np.column_stack([z.real, 500.0 - z.imag])
    assert (found.patch, found.mirrored) == ("panel", mirrored)
    np.testing.assert_allclose(found.place(OUTLINE), on_page, atol=1e-9)
    np.testing.assert_allclose(found.lines["sew"][0], on_page, atol=0.001)
    assert shapely.Polygon(found.lines["cut"][0]).area == pytest.approx(212.0 * 162.0, rel=1e-4)
    assert [len(line) for line in found.lines["grain"]] == [2, 3, 3]


@pytest.mark.parametrize("size", [(300.0, 40.0), (40.0, 300.0), (80.0, 80.0), (20.0, 20.0)])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_name_stays_in_its_piece_and_off_its_grain_arrow(tmp_path, size, mirrored):
    made = piece(OUTLINE / OUTLINE.max(axis=0) * size, cloth(), name="lower_thigh-a_inner")
    layout = Layout(cloth(), (Placement(made, 1, mirrored, 0.0, 0.0, 300.0 if mirrored else 0.0),))
    write_layout(tmp_path / "l.svg", layout, "x")
    (laid,) = read_layout(tmp_path / "l.svg")
    name = _name(laid, 1.0)
    assert "".join(name.lines).replace(" ", "") == "lower_thigh-a_inner" + "(mirrored)" * mirrored
    assert shapely.Polygon(laid.lines["sew"][0]).buffer(1e-6).covers(name.box)
    if min(size) > 20.0:
        assert name.height >= 5.0
        assert not any(shapely.LineString(line).intersects(name.box) for line in laid.lines["grain"])


def test_a_name_goes_beside_an_arrow_through_the_middle():
    square = np.array([[0, 0], [100, 0], [100, 100], [0, 100]], float)
    arrow = np.array([[10, 50], [90, 50]], float)
    name = _name(DrawnPiece("panel", False, np.eye(2), np.zeros(2), {"sew": [square], "grain": [arrow]}), 1.0)
    assert name.height == 10.0 and not shapely.LineString(arrow).intersects(name.box)


def test_rows_fill_the_width_and_hold_all_panels():
    random = np.random.default_rng(0)
    for count in range(1, 15):
        aspects = list(np.exp(random.uniform(-2.0, 2.0, count)))
        rows = break_rows(aspects)
        assert sum(n for n, _ in rows) == count
        rest = iter(aspects)
        for n, height in rows:
            width = height * sum(next(rest) for _ in range(n)) + GAP * (n - 1) + 2.0 * MARGIN
            assert width == pytest.approx(WIDTH) or (height == TALLEST_ROW and width < WIDTH)
        assert len(rows) * CAPTION < sum(height for _, height in rows)


@pytest.mark.parametrize("width", [0.5, 0.69, 0.76, 0.95, 3.0])
def test_captions_of_narrow_panels_beside_each_other_stay_apart(width):
    """Measured as matplotlib draws them."""
    sheet = "600\u00a0×\u00a0138\u00a0mm"
    text, points, fits = fitted_caption(f"leather: {sheet}, 50\u00a0%\u00a0used", width)
    figure = Figure(figsize=(14, 8))
    box = figure.text(0.5, 0.5, text, fontsize=points).get_window_extent(FigureCanvasAgg(figure).get_renderer())
    assert box.width / figure.dpi < width + (0.0 if fits else GAP)
    assert sheet in text and points >= 5.0


def spoil(name, content):
    def do(folder):
        write_build(folder)
        (folder / name).write_text(content)

    return do


def without(name):
    def do(folder):
        write_build(folder)
        (folder / name).unlink()

    return do


def foreign(folder):
    folder.mkdir()
    (folder / "holiday.txt").write_text("sun")


@pytest.mark.parametrize(
    "prepare, words",
    [
        (lambda folder: None, ["is no folder"]),
        (foreign, ["no report.json", "flatnet build"]),
        (spoil("report.json", "{"), ["report.json", "build again"]),
        (spoil("report.json", "[]"), ["report.json", "build again"]),
        (spoil("report.json", '{"format": "other/1"}'), ["'other/1'", "flatnet-report/1"]),
        (spoil("report.json", '{"format": "flatnet-report/1"}'), ["report.json", "'patches'"]),
        (spoil("network.json", "\x00"), ["network.json", "build again"]),
        (spoil("layout-cloth.svg", "<svg"), ["layout-cloth.svg", "not a layout of flatnet"]),
        (spoil("patches/tent.obj", "v 0 0 0\nf 1 2 3\n"), ["tent.obj", "not an OBJ of flatnet"]),
        (spoil("patches/tent.obj", "v 0 0\nvt 0 0\nf 1/1 1/1 1/1\n"), ["tent.obj", "for each"]),
        (spoil("patches/tent.obj", "v 0 0 0\nvt 0 0\nf 1/1 1/1 2/2\n"), ["tent.obj", "not there"]),
        (spoil("patches/tent.obj", ""), ["tent.obj", "not an OBJ of flatnet"]),
        (without("patches/tent.initial.obj"), ["tent.initial.obj", "No such file", "build again"]),
    ],
)
def test_what_is_no_build_is_said_in_one_line(tmp_path, capsys, prepare, words):
    prepare(tmp_path / "out")
    assert main(["draw", str(tmp_path / "out"), "-o", str(tmp_path / "a.png")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and str(tmp_path / "out") in said
    assert all(word in said for word in words), said
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize("picture, words", [("a.svg", "a PNG"), ("none/a.png", "can't be written")])
def test_a_picture_that_cannot_be_written_is_said_in_one_line(tmp_path, capsys, picture, words):
    assert main(["draw", str(write_build(tmp_path / "out")), "-o", str(tmp_path / picture)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and picture in said and words in said


def test_without_matplotlib_only_drawing_fails_and_says_how_to_install_it(tmp_path):
    """In a process of its own, in which matplotlib can't be imported."""
    folder = write_build(tmp_path / "out")
    code = (
        "import sys; sys.modules['matplotlib'] = None; "
        "from flatnet.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    done = subprocess.run([sys.executable, "-c", code, "draw", str(folder)], capture_output=True, text=True)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "pip install matplotlib" in done.stderr


def test_drawing_needs_no_display(tmp_path):
    """pyplot, which would choose a window system, is never loaded."""
    folder = write_build(tmp_path / "out")
    code = (
        "import sys; from flatnet.cli import main; status = main(sys.argv[1:]); "
        "sys.exit(status or 10 * ('matplotlib.pyplot' in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code, "draw", str(folder)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert imread(io.BytesIO((tmp_path / "out.png").read_bytes())).ndim == 3
