"""Text on written pieces, measured in the widest of the common faces: inside the piece and clear of every line."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from pieces import LETTER_F, blob, cloth, fitted

from flatnet.export.svg import write_layout, write_piece
from flatnet.nesting import Layout, Placement
from flatnet.network.patch import Stretch
from flatnet.pattern import make_piece
from flatnet.pattern.labels import line_breaks, text_width
from flatnet.pattern.notches import SeamNotch
from flatnet.pattern.seams import Seam
from flatnet.project.seam_specs import NotchSpec, SeamSpec

SVG = "{http://www.w3.org/2000/svg}"
FACE = FontProperties(family="DejaVu Sans")


def made(outline, name="lower_thigh_back_outer", **rest):
    """A piece with long seam names and notches that reach inside."""
    count = len(outline)
    size = max(1, count // 4)
    stretches = tuple(
        Stretch(f"inseam:knee..hem_{i}", i, min(size, count - i), i % 2 == 0) for i in range(0, count, size)
    )
    spec = SeamSpec(notches=NotchSpec(depth=6.0))
    seams = {
        stretch.seam: Seam(stretch.seam, 7 + i, f"c{i}", spec, (name, "other"), 50.0, (SeamNotch(0, 0.5, 9.0, 2),))
        for i, stretch in enumerate(stretches)
    }
    patch = fitted(outline, name=name, stretches=stretches, **rest)
    return make_piece(patch, cloth(allowance=4.0), seams, "pants · 38")


def numbers(text):
    return [float(number) for number in re.findall(r"[-+.\d]+(?:e[-+]?\d+)?", text)]


def inked(text):
    """The rectangle that the drawn letters of a text element need, in the piece's frame."""
    letters = TextPath((0, 0), text.text, size=float(text.get("font-size")), prop=FACE).vertices
    (left, bottom), (right, top) = letters.min(axis=0), letters.max(axis=0)
    middle = 0.5 * TextPath((0, 0), text.text, size=float(text.get("font-size")), prop=FACE).get_extents().width
    x, y = float(text.get("x")), float(text.get("y"))
    corners = np.array([[left, bottom], [right, bottom], [right, top], [left, top]]) - [middle, 0.0]
    corners = [x, y] + corners * [1.0, -1.0]
    a, b, c, d, e, f = numbers(text.get("transform"))
    return shapely.Polygon(corners @ np.array([[a, b], [c, d]]) + [e, f])


def check(group):
    parts = {"sew": [], "cut": [], "notch": [], "grain": []}
    for path in group.iter(f"{SVG}path"):
        for part in path.get("d").split("M")[1:]:
            points = np.reshape(numbers(part), (-1, 2))
            closed = "Z" in part
            parts[path.get("class")].append(np.vstack([points, points[:1]]) if closed else points)
    lines = shapely.union_all([shapely.LineString(line) for group in parts.values() for line in group])
    sew = shapely.Polygon(parts["sew"][0])
    boxes = [inked(text) for text in group.iter(f"{SVG}text")]
    assert len(boxes) > 3
    for i, box in enumerate(boxes):
        assert sew.contains(box)
        assert not box.intersects(lines)
        assert not any(box.intersects(other) for other in boxes[:i])
    return [text for text in group.iter(f"{SVG}text")]


def pieces_in(path):
    return [g for g in ElementTree.parse(path).getroot().iter(f"{SVG}g") if g.get("class") == "piece"]


SHAPES = [LETTER_F, 3 * LETTER_F, blob(1), blob(2, 90, 40), blob(3, 60, 45), blob(5, 300, 60), blob(6, 180, 160)]


@pytest.mark.parametrize("outline", SHAPES, ids=range(len(SHAPES)))
def test_text_lies_inside_the_piece_and_covers_no_line(outline, tmp_path):
    piece = made(outline)
    assert piece.notches
    write_piece(tmp_path / "piece.svg", piece)
    (group,) = pieces_in(tmp_path / "piece.svg")
    texts = check(group)
    assert min(float(text.get("font-size")) for text in texts) >= (2.0 if np.ptp(outline[:, 1]) > 50 else 1.2)


def test_on_a_layout_too_turned_and_mirrored(tmp_path):
    piece = made(blob(1, 200, 120), cut=2, mirrored=1)
    placements = (
        Placement(piece, 1, False, 30.0, 120.0, 120.0),
        Placement(piece, 2, False, 180.0, 400.0, 120.0),
        Placement(piece, 3, True, 90.0, 650.0, 150.0),
    )
    write_layout(tmp_path / "layout.svg", Layout(cloth(), placements), "pants · 38")
    groups = pieces_in(tmp_path / "layout.svg")
    assert len(groups) == 3
    for group in groups:
        said = [text.text for text in check(group)]
        assert {"cut 2 + 1 mirrored", "cloth", "pants · 38"} <= set(said)


def test_numbers_stand_at_every_seam_and_the_table_says_what_they_mean(tmp_path):
    piece = made(blob(2, 90, 40))
    write_piece(tmp_path / "piece.svg", piece)
    root = ElementTree.parse(tmp_path / "piece.svg").getroot()
    (group,) = pieces_in(tmp_path / "piece.svg")
    on_piece = {text.text.split()[0] for text in group.iter(f"{SVG}text")}
    assert {"7", "8", "9", "10"} <= on_piece
    all_texts = [text.text for text in root.iter(f"{SVG}text")]
    for run in piece.seams:
        row = f"{run.seam.number} {run.seam.name} · 50.0 mm · lower_thigh_back_outer + other"
        assert all_texts.count(row) == 1
    _, _, width, height = numbers(root.get("viewBox"))
    for text in root.iter(f"{SVG}text"):
        if " mm · " in text.text:
            assert 0 < float(text.get("y")) < height
            assert float(text.get("x")) + text_width(text.text) * float(text.get("font-size")) <= width


def test_widths_are_not_less_than_those_of_the_face():
    for text in ("lower_thigh_back_outer", "MAMMOTH", "12 hem:a..b", "gap = 3 mm @ 100%", "Größe 38–40", "W.W.W"):
        drawn = TextPath((0, 0), text, size=100, prop=FACE).get_extents().width / 100
        assert drawn <= text_width(text)


def test_names_break_at_their_signs():
    broken = line_breaks("lower_thigh_back_outer")
    assert broken[0] == ("lower_thigh_back_outer",)
    assert broken[1] == ("lower_thigh_", "back_outer")
    assert broken[-1] == ("lower_", "thigh_", "back_", "outer")
    assert all("".join(lines) == "lower_thigh_back_outer" for lines in broken)
