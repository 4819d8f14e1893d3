"""Layouts read back with svgelements, not a reader of ours, at 25.4 pixels to the inch: 1 pixel is 1 mm."""

import io

import numpy as np
import pytest
import shapely
from pieces import LETTER_F, SQUARE, blob, cloth, piece
from svgelements import SVG, Group, Path, Text

from flatnet.export.svg import write_layout, write_piece
from flatnet.nesting import Layout, Placement

#: Half of the last digit in both coordinates.
WRITTEN = 0.0005 * np.sqrt(2.0) + 1e-9

#: svgelements takes 0.0393701 inches for a mm, which is 5.4e-7 too many.
READER = 6e-7

MATERIAL = cloth(width=400.0, allowance=6.0)
F = piece(LETTER_F, MATERIAL, name="letter_f", cut=2, mirrored=1)
LAYOUT = Layout(
    MATERIAL,
    (
        Placement(F, 1, False, 0.0, 6.0, 6.0),
        Placement(F, 2, False, 123.456789, 250.0, 20.0),
        Placement(F, 3, True, 90.0, 300.0, 150.0),
    ),
)


def read(path):
    return SVG.parse(io.StringIO(path.read_text()), ppi=25.4)


def outline(group, kind):
    """Vertices of a path, where the drawing shows them."""
    (path,) = [e for e in group.select() if isinstance(e, Path) and e.values.get("class") == kind]
    assert type(path[-1]).__name__ == "Close"
    path = path * path.transform if not path.transform.is_identity() else path
    return np.array([[s.end.x, s.end.y] for s in path][:-1])


def groups(svg):
    return [e for e in svg.elements() if isinstance(e, Group) and e.values.get("class") == "piece"]


@pytest.fixture
def drawn(tmp_path):
    write_layout(tmp_path / "layout.svg", LAYOUT, "letters", missing=("toe cap", "tongue"))
    return read(tmp_path / "layout.svg")


def rigid_determinant(points, onto):
    """+1 or -1: the best orthogonal map between the figures turns or mirrors; and what it leaves, mm."""
    a, b = points - points.mean(axis=0), onto - onto.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    return np.sign(np.linalg.det(u @ v)), np.linalg.norm(a @ u @ v - b, axis=1).max()


def test_the_drawing_is_in_mm_and_names_every_copy(drawn):
    box = drawn.viewbox
    assert (box.width, box.height) == pytest.approx((drawn.width, drawn.height), rel=READER)
    found = [[g.values[f"data-{key}"] for key in ("patch", "copy", "mirrored")] for g in groups(drawn)]
    assert found == [["letter_f", "1", "false"], ["letter_f", "2", "false"], ["letter_f", "3", "true"]]


def test_a_chiral_piece_is_not_mirrored_and_its_mirrored_copy_is(drawn):
    seen = LETTER_F * [1.0, -1.0]  # the letter as a reader sees it, in SVG's y-down coordinates
    determinants = []
    for group in groups(drawn):
        determinant, left = rigid_determinant(seen, outline(group, "sew"))
        assert left <= 2 * WRITTEN
        determinants.append(determinant)
    assert determinants == [1.0, 1.0, -1.0]


@pytest.mark.parametrize("kind", ["sew", "cut"])
def test_vertices_lie_where_the_placement_puts_them(drawn, kind):
    for group, placement in zip(groups(drawn), LAYOUT.placements):
        line = F.sew_line if kind == "sew" else F.cut_line
        x, y = placement.place(line).T
        error = np.linalg.norm(outline(group, kind) - np.column_stack([x, MATERIAL.width - y]), axis=1)
        assert error.max() <= WRITTEN + READER * drawn.width


def test_coordinates_inside_a_group_are_the_flat_ones_to_a_thousandth(tmp_path):
    made = piece(blob(3) + 0.00049, MATERIAL, name="panel")
    write_piece(tmp_path / "panel.svg", made)
    (line,) = [t for t in (tmp_path / "panel.svg").read_text().splitlines() if 'class="sew"' in t]
    numbers = line.split('d="M ')[1].split(" Z")[0]
    written = np.array([[float(n) for n in pair.split(",")] for pair in numbers.split()])
    assert np.linalg.norm(written - made.sew_line, axis=1).max() <= WRITTEN
    assert max(len(n.split(".")[1]) for pair in numbers.split() for n in pair.split(",")) <= 3


def test_holes_are_closed_parts_of_the_cut_path(tmp_path):
    inner = 0.4 * SQUARE + 30.0
    ring = np.concatenate([SQUARE, SQUARE[:1], inner[[0, 3, 2, 1, 0]]])
    made = piece(ring, MATERIAL, name="ring")
    write_piece(tmp_path / "ring.svg", made)
    (group,) = groups(read(tmp_path / "ring.svg"))
    (cut,) = [e for e in group.select() if isinstance(e, Path) and e.values.get("class") == "cut"]
    assert [type(segment).__name__ for segment in cut].count("Close") == 2
    (hole,) = made.holes
    assert np.ptp(hole, axis=0) == pytest.approx([28.0, 28.0])  # 40 mm less an allowance of 6 on both sides


def texts(svg):
    return [e for e in svg.elements() if isinstance(e, Text)]


def test_text_is_never_mirrored_nor_upside_down(drawn):
    assert len(texts(drawn)) > 20
    for text in texts(drawn):
        m = text.transform
        assert m.a * m.d - m.b * m.c == pytest.approx(1.0, rel=2 * READER)
        assert m.a >= -1e-6


def test_the_title_says_project_size_use_and_what_is_missing(drawn):
    said = "\n".join(text.text for text in texts(drawn))
    for words in ("letters", "cloth", f"400 x {LAYOUT.used_length:.1f} mm",
                  f"{100 * LAYOUT.utilisation:.1f} %", "INCOMPLETE: missing toe cap, tongue"):
        assert words in said
    assert "draft" not in said


def test_a_draft_says_so(tmp_path):
    write_layout(tmp_path / "d.svg", Layout(MATERIAL, LAYOUT.placements, draft=True), "letters")
    said = [text.text for text in texts(read(tmp_path / "d.svg"))]
    assert any("draft" in line for line in said) and not any("INCOMPLETE" in line for line in said)


def test_sheet_and_test_square_have_their_true_size_and_the_square_is_clear_of_the_sheet(drawn):
    paths = {e.values.get("class"): e for e in drawn.elements() if isinstance(e, Path)}
    left, top, right, bottom = paths["test-square"].bbox(with_stroke=False)
    assert (right - left, bottom - top) == pytest.approx((50.0, 50.0), rel=READER)
    x0, y0, x1, y1 = paths["sheet"].bbox(with_stroke=False)
    assert (x1 - x0, y1 - y0) == pytest.approx((LAYOUT.used_length, 400.0), abs=1e-3)
    assert top > y1 and right <= drawn.width and bottom <= drawn.height


def test_cut_and_sew_lines_have_their_own_colours(drawn):
    colours = {e.values.get("class"): e.stroke.hexrgb for e in drawn.elements() if isinstance(e, Path)}
    assert len({colours[kind] for kind in ("cut", "sew", "grain", "sheet")}) == 4


def test_labels_stay_inside_their_piece_on_the_drawing(drawn):
    for group, placement in zip(groups(drawn), LAYOUT.placements):
        region = shapely.Polygon(outline(group, "sew"))
        for text in (e for e in group.select() if isinstance(e, Text)):
            m = text.transform
            assert region.contains(shapely.Point(m.e, m.f)), (str(placement), text.text)


def test_a_single_piece_is_drawn_right_side_up(tmp_path):
    made = piece(LETTER_F, MATERIAL, name="f")
    write_piece(tmp_path / "f.svg", made)
    svg = read(tmp_path / "f.svg")
    (group,) = groups(svg)
    sew = outline(group, "sew")
    np.testing.assert_allclose(sew - sew[0], (LETTER_F - LETTER_F[0]) * [1.0, -1.0], atol=2 * WRITTEN)
    cut = outline(group, "cut")
    assert cut.min() > 0.0 and cut[:, 0].max() < svg.width and cut[:, 1].max() < svg.height


def test_names_with_letters_of_xml_are_written(tmp_path):
    made = piece(SQUARE, MATERIAL, name="<a> & 'b\"")
    write_piece(tmp_path / "x.svg", made)
    (group,) = groups(read(tmp_path / "x.svg"))
    assert group.values["data-patch"] == "<a> & 'b\""


def test_the_same_layout_gives_the_same_bytes(tmp_path):
    for name in ("a.svg", "b.svg"):
        write_layout(tmp_path / name, LAYOUT, "letters")
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_a_coordinate_beyond_a_metre_keeps_its_last_digit(tmp_path):
    """A path written with six significant digits would lose 0.005 mm here."""
    long = np.array([[-1234.567, 0.0], [1234.567, 0.0], [1234.567, 80.0], [-1234.567, 80.0]])
    write_piece(tmp_path / "long.svg", piece(long, cloth(width=3000.0), name="long"))
    (group,) = groups(read(tmp_path / "long.svg"))
    seen = np.ptp(outline(group, "sew")[:, 0])
    assert seen == pytest.approx(2469.134, abs=2 * WRITTEN + READER * 2469.134)
