"""Files with curves: what is read, and what is said about a file that can't be."""

import json
import sys

import numpy as np
import pytest

from flatnet.project.drawings import DrawingError, read_drawing


def written(folder, name, text):
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def points_of(curves):
    return {curve.name: curve.points.tolist() for curve in curves}


# --- OBJ


OBJ = """\
# comment
v 0 0 0
v 1 0 0
v 1 1 0.5
o top line
l 1 2 3
vt 0 0
g ring
l 1/1 2/1 -1 1
f 1 2 3
"""


def test_obj(tmp_path):
    curves = read_drawing(written(tmp_path, "net.OBJ", OBJ))
    assert points_of(curves) == {
        "top_line": [[0, 0, 0], [1, 0, 0], [1, 1, 0.5]],
        "ring": [[0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 0, 0]],
    }
    assert [curve.closed for curve in curves] == [False, True]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0 0\nv 1 0 0\nl 1 3\n", "line 3: an 'l' needs two or more of the file's 2 vertices"),
        ("v 0 0 0\nl 1\n", "line 2: an 'l' needs two"),
        ("v 0 0 0\nv 1 1 1\nl 0 1\n", "line 3: an 'l' needs"),
        ("v 0 0\n", "line 1: 'v 0 0' is no vertex"),
        ("v 0 0 0\nv 1 1 1\nl 1 b\n", "line 3: 'l 1 b' is no vertex or line"),
        ("v 0 0 0\nv 1 1 nan\nl 1 2\n", "coordinates that are no finite numbers"),
        ("v 0 0 0\n", "has no curves"),
    ],
)
def test_bad_obj(text, message, tmp_path):
    with pytest.raises(DrawingError, match=message):
        read_drawing(written(tmp_path, "net.obj", text))


# --- CSV


@pytest.mark.parametrize(
    "text",
    [
        "0,0,0\n1,2.5,-3e1\n",
        "\ufeffx,y,z\n0,0,0\n1,2.5,-30\n",
        "# made by hand\n\n0; 0; 0\n1; 2.5; -30\n",
        "0\t0\t0\n1\t2.5\t-30",
        "Z,name,X,Y\n0,a,0,0\n-30,b,1,2.5\n",
    ],
)
def test_csv(text, tmp_path):
    assert points_of(read_drawing(written(tmp_path, "side.csv", text))) == {"side": [[0, 0, 0], [1, 2.5, -30]]}


def test_csv_of_several_curves(tmp_path):
    text = "curve,x,y,z\nhem,0,0,0\nside,5,5,5\nhem,1,0,0\nside,6,5,5\n"
    assert points_of(read_drawing(written(tmp_path, "net.csv", text))) == {
        "hem": [[0, 0, 0], [1, 0, 0]], "side": [[5, 5, 5], [6, 5, 5]],
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b,c\n0,0,0\n", "line 1: expected the columns x, y, z"),
        ("0,0,0\n1,2\n", "line 2: expected numbers x, y, z, got 1, 2"),
        ("0,0,0\n\n1,2,x\n", "line 3: expected numbers"),
        ("0,0,0\n", "fewer than two points"),
        ("", "has no curves"),
    ],
)
def test_bad_csv(text, message, tmp_path):
    with pytest.raises(DrawingError, match=message):
        read_drawing(written(tmp_path, "side.csv", text))


# --- strokes


def strokes(**change):
    """A quarter of a circle, as well as a cubic can be one, and a line on from it, in one stroke; a stroke apart."""
    k = 0.5522847498
    content = {
        "nodes": [{"id": i, "position": p} for i, p in enumerate([[1, 0, 0], [0, 1, 0], [-1, 1, 0], [5, 5, 5]])],
        "segments": [
            {"id": 10, "ctrl_pts": [[[1, 0, 0], [1, k, 0], [k, 1, 0], [0, 1, 0]]], "nodes": [0, 1]},
            {"id": 11, "ctrl_pts": [[[0, 1, 0], [-1, 1, 0]]], "nodes": [1, 2]},
            {"id": 12, "ctrl_pts": [[[1, 0, 0], [2, 0, 0]], [[2, 0, 0], [5, 5, 5]]], "nodes": [0, 3]},
        ],
        "strokes": [{"id": 7, "segments": [10, 11]}, {"id": 8, "segments": [12]}, {"id": 9, "segments": [10, 12]}],
    }
    return json.dumps({**content, **change})


def test_strokes(tmp_path):
    curves = read_drawing(written(tmp_path, "net.json", strokes()))
    assert [curve.name for curve in curves] == ["stroke_7", "stroke_8", "stroke_9", "stroke_9"]  # 9 is in two parts
    arc = curves[0].points[:-1]
    np.testing.assert_allclose(np.linalg.norm(arc, axis=1), 1.0, atol=3e-4)  # how near a cubic is to a quarter circle
    assert curves[0].points[-2:].tolist() == [[0, 1, 0], [-1, 1, 0]]
    assert curves[1].points.tolist() == [[1, 0, 0], [2, 0, 0], [5, 5, 5]]
    assert all(curve.smooth for curve in curves)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "line 1: no valid JSON"),
        ("[]", "no network of strokes, segments and nodes"),
        (strokes(nodes=[]), "no network of strokes"),
        (strokes(strokes=[]), "has no curves"),
        (strokes(nodes=[{"id": i, "position": [9, 9, 9]} for i in range(4)]), "segment 10 does not end at its nodes"),
        (strokes(nodes=[{"id": 0, "position": [9, "a", 9]}]), "expected 3 numbers, got"),
        (strokes(segments=[{"id": 10, "ctrl_pts": [], "nodes": [0, 1]}]), "no network of strokes"),
    ],
)
def test_bad_strokes(text, message, tmp_path):
    with pytest.raises(DrawingError, match=message):
        read_drawing(written(tmp_path, "net.json", text))


def test_other_files(tmp_path):
    with pytest.raises(DrawingError, match=r"ends in .*\.csv.*, not in '.xyz'"):
        read_drawing(written(tmp_path, "net.xyz", ""))
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(DrawingError, match="can't be read"):
        read_drawing(tmp_path / "folder.csv")


# --- SVG and DXF


def shapes_of(curves):
    return [(curve.name, curve.smooth, curve.closed) for curve in curves]


PAGE = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 200 100">{}</svg>'


def test_svg_is_in_mm_and_right_side_up(tmp_path):
    """Two units of this page are a mm; a transform of a group counts; y is up."""
    body = '<g transform="translate(20, 10)"><polyline id="top line" points="0,0 10,0 10,20"/></g><text>words</text>'
    [curve] = read_drawing(written(tmp_path, "net.svg", PAGE.format(body)))
    assert (curve.name, curve.smooth) == ("top line", False)
    np.testing.assert_allclose(curve.points, [[10, -5, 0], [15, -5, 0], [15, -15, 0]], atol=1e-9)


def test_svg_shapes(tmp_path):
    body = """
      <circle id="c" cx="60" cy="40" r="20"/>
      <rect id="r" x="0" y="0" width="20" height="10"/>
      <path id="p" d="M 0 0 L 10 0 C 20 0 20 10 20 20 L 0 20 Z"/>
      <path id="q" d="M 0 0 Q 10 20 20 0 M 30 0 H 40"/>
      <path id="a" d="M 0 0 A 10 10 0 0 1 20 0"/>"""
    curves = read_drawing(written(tmp_path, "net.svg", PAGE.format(body)))
    assert shapes_of(curves) == [
        ("c", True, True),
        ("r", False, True),
        ("p", True, False), ("p", False, False), ("p", False, False),  # divided at its corners
        ("q", True, False), ("q", False, False),
        ("a", True, False),
    ]  # fmt: skip
    circle, parabola, arc = curves[0], curves[5], curves[7]
    np.testing.assert_allclose(np.linalg.norm(circle.points - [30, -20, 0], axis=1), 10.0, rtol=3e-4)
    x, y, _ = parabola.points.T
    np.testing.assert_allclose(y, -x * (10 - x) / 5, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(arc.points - [5, 0, 0], axis=1), 5.0, rtol=3e-4)


@pytest.mark.parametrize("text", ["<svg", "hello", ""])
def test_bad_svg(text, tmp_path):
    with pytest.raises(DrawingError, match=r"no SVG that can be read"):
        read_drawing(written(tmp_path, "net.svg", text))


def test_svg_without_shapes(tmp_path):
    with pytest.raises(DrawingError, match="has no curves"):
        read_drawing(written(tmp_path, "net.svg", PAGE.format("<text>words</text>")))


@pytest.fixture
def dxf(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new()

    def saved():
        document.saveas(tmp_path / "net.dxf")
        return tmp_path / "net.dxf"

    return document.modelspace(), saved


def test_dxf(dxf):
    space, saved = dxf
    space.add_line((0, 0, 5), (10, 0, 5), dxfattribs={"layer": "hem"})
    space.add_polyline3d([(0, 0, 0), (1, 2, 3), (4, 5, 6)])
    space.add_lwpolyline([(0, 0, 0), (10, 0, 1), (10, 10, 0)], format="xyb", dxfattribs={"layer": "side"})
    space.add_lwpolyline([(0, 0), (9, 0), (9, 9)], close=True)
    space.add_circle((1, 2, 3), 10)
    space.add_ellipse((0, 0, 0), (10, 0, 0), 0.5, 0, np.pi)
    space.add_text("words")
    curves = read_drawing(saved())
    assert shapes_of(curves) == [
        ("hem", False, False),
        ("0", False, False),
        ("side", True, False),  # a line that goes on smoothly in a half circle
        ("0", False, True),
        ("0", True, True),
        ("0", True, False),
    ]  # fmt: skip
    assert curves[0].points.tolist() == [[0, 0, 5], [10, 0, 5]]
    np.testing.assert_allclose(curves[2].points[:17, 1:], 0.0, atol=1e-12)
    half, circle, ellipse = curves[2].points[16:], curves[4].points, curves[5].points
    np.testing.assert_allclose(np.linalg.norm(half - [10, 5, 0], axis=1), 5.0, rtol=3e-4)
    assert half[:, 0].max() == pytest.approx(15)
    np.testing.assert_allclose(np.linalg.norm(circle - [1, 2, 3], axis=1), 10.0, rtol=3e-4)
    np.testing.assert_allclose((ellipse[:, 0] / 10) ** 2 + (ellipse[:, 1] / 5) ** 2, 1.0, rtol=1e-3)


def test_dxf_splines_are_exact(dxf):
    """A cubic B-spline is cubic Bezier segments: their samples lie on it."""
    space, saved = dxf
    spline = space.add_spline()
    spline.set_open_uniform([(0, 0, 0), (3, 8, 1), (9, 8, 4), (12, 0, 2), (20, 1, 0)])
    curves = read_drawing(saved())
    dense = np.array([tuple(p) for p in spline.construction_tool().approximate(4000)])
    assert shapes_of(curves) == [("0", True, False)]
    away = np.linalg.norm(curves[0].points[:, None] - dense[None], axis=2).min(axis=1)
    assert away.max() < 0.01  # half the distance of the dense points
    np.testing.assert_allclose(curves[0].points[[0, -1]], [[0, 0, 0], [20, 1, 0]], atol=1e-12)


@pytest.mark.parametrize("text", ["hello", "", "0\nSECTION\n2\nENTITIES\n0\nLINE\nbroken\n"])
def test_bad_dxf(text, tmp_path):
    pytest.importorskip("ezdxf")
    with pytest.raises(DrawingError, match=r"read|no curves"):
        read_drawing(written(tmp_path, "net.dxf", text))


@pytest.mark.parametrize(("suffix", "package"), [(".dxf", "ezdxf"), (".svg", "svgelements")])
def test_without_its_package_a_drawing_says_what_to_install(suffix, package, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(DrawingError, match=f"needs {package}: pip install {package}"):
        read_drawing(written(tmp_path, f"net{suffix}", ""))
