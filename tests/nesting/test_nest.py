"""Layouts: valid whatever the pieces, made once and kept, what doesn't fit reported and the rest laid."""

import json

import numpy as np
import pytest
import shapely
from pieces import LETTER_F, SQUARE, blob, cloth, piece

from flatnet.nesting import Layout, Placement, check_layouts, nest, read_stored, write_stored
from flatnet.nesting.engine import EngineError, Item, Strip, run_engine
from flatnet.nesting.layout import copies_of, turn
from flatnet.nesting.roll import nest_on_roll
from flatnet.nesting.rows import lay_in_rows
from flatnet.parameters import NestingParameters

QUICK = NestingParameters(seconds=1)


def panels(material, count=4, **size):
    return [
        piece(blob(seed, **size), material, name=f"panel_{seed}", cut=1, mirrored=seed % 2)
        for seed in range(count)
    ]


def rectangle(length, width):
    return np.array([[0, 0], [length, 0], [length, width], [0, width]], float)


def test_the_map_of_a_placement():
    # p -> R M p + (x, y): M turns (1, 2) into (1, -2), a quarter turn that into (2, 1).
    placement = Placement(piece(SQUARE), 1, True, 90.0, 10.0, 20.0)
    np.testing.assert_allclose(placement.place(np.array([[1.0, 2.0]])), [[12.0, 21.0]], atol=1e-13)


def test_mirrored_copies_keep_the_grain_along_the_roll():
    assert turn(0.0, True)[:, 0].tolist() == [1.0, 0.0]
    assert np.linalg.det(turn(37.0, True)) == pytest.approx(-1.0, abs=1e-15)


def test_used_length_and_utilisation():
    made = piece(SQUARE, cloth(width=200.0))
    layout = Layout(cloth(width=200.0), (Placement(made, 1, False, 0.0, 50.0, 0.0),))
    assert layout.used_length == 150.0
    assert layout.utilisation == pytest.approx(1e4 / (200.0 * 150.0), rel=1e-15)


@pytest.mark.parametrize(
    "changes",
    [
        {"gap": 3.0, "allowance": 10.0},
        {"gap": 0.0},
        {"rotations": (0.0,), "gap": 1.0},
        {"rotations": None, "gap": 2.0},
        {"rotations": (0.0, 90.0, 215.0), "width": 1100.0},
    ],
)
def test_the_engine_lays_trousers_validly(changes):
    material = cloth(**{"width": 1000.0, **changes})
    pieces = [*panels(material), piece(3 * LETTER_F, material, name="F", cut=2, mirrored=1)]
    (layout,), findings = nest(pieces, material, QUICK)
    assert findings == () and not layout.draft
    assert check_layouts([layout], pieces) == []
    starts = [p.place(p.piece.cut_line)[:, 0].min() for p in layout.placements]
    assert min(starts) == pytest.approx(0.0, abs=1e-9)
    # Never worse than plain rows, however little the engine got done in its time.
    rows = Layout(material, tuple(lay_in_rows(copies_of(pieces), material)))
    assert layout.used_length <= rows.used_length


def test_pieces_as_wide_as_the_roll_fit():
    material = cloth(width=500.0, gap=2.0)
    pieces = [piece(rectangle(200.0, 500.0), material, name="full", cut=2),
              piece(rectangle(80.0, 100.0), material, name="pocket", cut=4)]
    (layout,), findings = nest(pieces, material, QUICK)
    assert findings == () and not layout.draft
    # 200 + 2 + 200 + 2 + 80 is the least there is.
    assert layout.used_length == pytest.approx(484.0, abs=1e-5)


def test_pieces_that_fill_the_roll_side_by_side_are_laid_so():
    material = cloth(width=1000.0)
    pieces = [piece(rectangle(300.0, 500.0), material, cut=4)]
    (layout,), findings = nest(pieces, material, QUICK)
    assert findings == () and layout.used_length == pytest.approx(600.0, abs=1e-5)


def test_pieces_that_are_too_wide_side_by_side_by_less_than_the_engines_play_are_laid_otherwise():
    # The engine's first strip is 0.1 mm wider than the roll; there two of them go, on the roll they don't.
    material = cloth(width=1000.0)
    pieces = [piece(rectangle(300.0, 500.03), material, cut=4)]
    (layout,), findings = nest(pieces, material, QUICK)
    assert findings == () and not layout.draft
    assert layout.used_length == pytest.approx(1200.0, abs=1e-5)


def test_far_from_the_origin_in_the_flat_frame_changes_nothing():
    material = cloth(gap=1.0)
    pieces = [piece(LETTER_F + 1e6, material, name="F", cut=2, mirrored=2)]
    (layout,), _ = nest(pieces, material, QUICK)
    assert check_layouts([layout], pieces) == [] and not layout.draft


@pytest.mark.parametrize("mirrored", [0, 1])
def test_a_piece_wider_than_the_roll_is_reported_and_the_others_go_on(mirrored):
    material = cloth(width=500.0, allowance=10.0)
    wide = piece(rectangle(100.0, 600.0), material, name="wide", mirrored=mirrored)
    good = piece(SQUARE, material, name="good")
    (layout,), (finding,) = nest([wide, good], material, QUICK)
    assert finding.code == "sheet_too_small" and finding.patch == "wide"
    assert finding.amount == pytest.approx(620.0) and finding.unit == "mm"
    assert "620.0 mm" in finding.message and "500.0 mm" in finding.message
    assert [str(p) for p in layout.placements] == ["good copy 1"]


def test_a_piece_longer_than_the_longest_layout_is_reported():
    material = cloth(width=500.0, length=550.0)
    (layouts, (finding,)) = nest([piece(rectangle(600.0, 100.0), material)], material, QUICK)
    assert layouts == ()
    assert finding.code == "sheet_too_small" and "600.0 mm long" in finding.message


def test_free_rotation_finds_the_narrowest_way_through():
    # A strip 60 mm wide, lying at 33 degrees in its own frame, on a roll of 61 mm.
    material = cloth(width=61.0, rotations=None)
    strip = rectangle(300.0, 60.0) @ turn(33.0, False).T
    (layout,), findings = nest([piece(strip, material)], material, QUICK)
    assert findings == ()
    assert layout.used_length == pytest.approx(300.0, abs=1e-6)


def test_what_does_not_fit_the_length_goes_on_further_sheets():
    material = cloth(width=210.0, length=215.0, gap=2.0)
    pieces = [piece(SQUARE, material, cut=6)]
    layouts, findings = nest(pieces, material, QUICK)
    assert findings == ()
    assert [layout.sheet for layout in layouts] == list(range(1, len(layouts) + 1))
    assert len(layouts) == 2
    assert check_layouts(layouts, pieces) == []


def test_a_single_copy_is_laid_at_once_and_is_no_draft():
    said = []
    (layout,), _ = nest([piece(SQUARE)], cloth(), NestingParameters(seconds=3600), None, said.append)
    assert not layout.draft and layout.used_length == 100.0
    assert not any("nesting" in text for text in said)


@pytest.mark.parametrize("seed", range(3))
def test_plain_rows_are_valid_and_always_the_same(seed):
    material = cloth(width=700.0, gap=4.0, allowance=5.0)
    pieces = panels(material, count=5, length=300.0 + 50.0 * seed)
    first, second = (lay_in_rows(copies_of(pieces), material) for _ in range(2))
    assert check_layouts([Layout(material, tuple(first))], pieces) == []
    assert [(str(p), p.x_mm, p.y_mm) for p in first] == [(str(p), p.x_mm, p.y_mm) for p in second]


def run(width=200.0, separation=1.0, seconds=1, limit=20.0, told=None):
    items = [Item.of(shapely.Polygon(SQUARE), count=3)]
    told = [] if told is None else told
    parameters = NestingParameters(seconds=seconds)
    return run_engine(Strip(width, separation), items, parameters, lambda *news: told.append(news), limit)


@pytest.mark.parametrize("changes", [{"width": 50.0}, {"separation": float("nan")}])
def test_a_panic_of_the_engine_is_caught(changes):
    with pytest.raises(EngineError, match=r"PanicException|status"):
        run(**changes)


def test_an_engine_past_its_time_is_ended():
    with pytest.raises(EngineError, match="still running"):
        run(seconds=30, limit=0.5)


def test_the_engine_tells_how_it_comes_on():
    told = []
    placed = run(seconds=2, told=told)
    assert [item for item, *_ in placed] == [0, 0, 0]
    # Three squares of 100 in a row, with a separation between them and at both ends; nothing is shorter.
    lengths = [length for length, _ in told]
    assert lengths and lengths == sorted(lengths, reverse=True)
    assert 304.0 - 0.01 <= lengths[-1] <= 320.0
    assert all(len(layout) == 3 for _, layout in told)


def few(material):
    return [piece(0.5 * SQUARE, material, cut=2)]


def frayed(material):
    outline = blob(0, 200.0, 140.0, 280)
    return [piece(outline * np.random.default_rng(0).uniform(0.95, 1.05, (280, 1)), material, cut=2)]


@pytest.mark.parametrize("made", [few, frayed])
def test_where_the_engines_own_offset_leaves_nothing_the_layout_is_no_draft(made):
    # Of a strip as short as a few pieces need at first, and of outlines with fine teeth.
    material = cloth(width=1500.0, gap=10.0)
    pieces = made(material)
    (layout,), findings = nest(pieces, material, QUICK)
    assert findings == () and not layout.draft
    assert check_layouts([layout], pieces) == []


def test_where_the_engine_dies_the_layout_is_a_valid_draft():
    # On a roll of 10 km the engine panics: single precision leaves nothing of its strip.
    material = cloth(width=1e7)
    pieces = [piece(SQUARE, material, cut=2)]
    with pytest.raises(EngineError):
        nest_on_roll(copies_of(pieces), material, QUICK)
    layouts, (finding,) = nest(pieces, material, QUICK)
    assert finding.code == "draft_layout" and finding.patch == ""
    assert all(layout.draft for layout in layouts)
    assert check_layouts(layouts, pieces) == []


@pytest.fixture(scope="module")
def nested():
    stored = TestStored()
    return nest(stored.pieces, stored.material, QUICK)[0]


class TestStored:
    material = cloth(width=300.0, gap=2.0)

    @property
    def pieces(self):
        return [piece(LETTER_F, self.material, name="F", cut=2, mirrored=2)]

    @pytest.fixture
    def file(self, tmp_path, nested):
        write_stored(tmp_path / "layout.json", nested)
        return tmp_path / "layout.json"

    def nest(self, file, material=None, parameters=QUICK):
        said = []
        layouts, _ = nest(self.pieces, material or self.material, parameters, read_stored(file), said.append)
        assert check_layouts(layouts, self.pieces) == []
        return layouts, any("unchanged" in text for text in said)

    def test_nothing_changed_gives_the_same_placements(self, file):
        first, reused = self.nest(file)
        stored = json.loads(file.read_text())["layouts"]
        assert reused
        assert [
            [p.x_mm, p.y_mm, p.rotation_deg, p.mirrored] for p in first[0].placements
        ] == [
            [r["x_mm"], r["y_mm"], r["rotation_deg"], r["mirrored"]]
            for r in stored[first[0].digest]["sheets"][0]
        ]

    def test_what_the_layout_was_made_from_is_looked_at(self, file):
        assert not self.nest(file, cloth(width=300.0, gap=2.5))[1]
        assert not self.nest(file, parameters=NestingParameters(seconds=1, seed=1))[1]

    def test_a_layout_is_good_enough_where_the_engine_had_as_much_time(self, file):
        content = json.loads(file.read_text())
        (record,) = content["layouts"].values()
        record["seconds"] = 60
        file.write_text(json.dumps(content))
        (layout,), reused = self.nest(file)
        assert reused and layout.seconds == 60
        record["seconds"] = 0
        file.write_text(json.dumps(content))
        assert not self.nest(file)[1]

    @pytest.mark.parametrize(
        "text",
        ["", "{", "[]", "null", '{"format": "other/1", "layouts": {}}', '{"format": "flatnet-layout/2"}'],
    )
    def test_corrupt_and_foreign_files_are_ignored(self, tmp_path, text):
        (tmp_path / "bad.json").write_text(text)
        assert read_stored(tmp_path / "bad.json") == {}

    def test_a_binary_or_absent_file_is_ignored(self, tmp_path):
        (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00")
        assert read_stored(tmp_path / "binary.json") == {}
        assert read_stored(tmp_path / "absent.json") == {}

    @pytest.mark.parametrize(
        "edit",
        [
            {"x_mm": 0.0, "y_mm": 0.0, "rotation_deg": 0.0},  # all in one place
            {"x_mm": float("nan")},
            {"x_mm": "left"},
            {"patch": "other"},
            {"patch": ["F"]},
            {"copy": None},
        ],
    )
    def test_an_edited_layout_is_nested_again(self, file, edit):
        content = json.loads(file.read_text())
        for stored in content["layouts"].values():
            for record in stored["sheets"][0]:
                record.update(edit)
        file.write_text(json.dumps(content))
        assert not self.nest(file)[1]

    def test_drafts_are_not_stored(self, tmp_path):
        layout = Layout(self.material, (Placement(self.pieces[0], 1, False, 0.0, 0.0, 0.0),), draft=True)
        write_stored(tmp_path / "layout.json", [layout])
        assert read_stored(tmp_path / "layout.json") == {}


def test_outlines_that_touch_themselves_are_laid():
    material = cloth(width=300.0, gap=1.0)
    slit = np.array([[0, 0], [100, 0], [100, 50], [40, 50], [100, 50], [100, 100], [0, 100]], float)
    pieces = [piece(slit, material, name="slit", cut=2)]
    assert not shapely.Polygon(slit).is_valid
    layouts, findings = nest(pieces, material, QUICK)
    assert findings == () and check_layouts(layouts, pieces) == []
