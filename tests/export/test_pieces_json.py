"""pieces.json says of a piece all that is cut and drawn, to the last bit."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pieces import LETTER_F, SQUARE, cloth, fitted
from pieces import piece as plain_piece

from flatnet.export.pieces_json import PieceFile, read_pieces, write_pieces
from flatnet.export.svg import write_piece
from flatnet.network.patch import Stretch
from flatnet.pattern import make_piece
from flatnet.pattern.edging import Fold
from flatnet.pattern.nicks import Nick
from flatnet.pattern.notches import SeamNotch
from flatnet.pattern.seams import Seam
from flatnet.project.seam_specs import NotchSpec, SeamSpec

DOCS = Path(__file__).parents[2] / "docs" / "pieces.md"
#: Thirds, so that no coordinate is a short decimal.
OUTLINE = LETTER_F / 3.0 * 10.0


def notched_piece():
    """Two seams, the second against the boundary's direction, each with an allowance and a double notch."""
    stretches = (Stretch("front", 0, 4, False), Stretch("back", 4, 6, True))
    seams = {
        name: Seam(name, number, name, SeamSpec(width, width, notches=NotchSpec(kind=kind)), ("f", "g"), 50.0,
                   (SeamNotch(1, 0.25, 20.0, 2),))
        for name, number, width, kind in (("front", 1, 7.5, "V"), ("back", 2, 1.0 / 3.0, "slit"))
    }
    return make_piece(fitted(OUTLINE, name="f", cut=2, mirrored=1, stretches=stretches), cloth(), seams, "letters · 38")


@pytest.fixture
def written(tmp_path):
    nick = Nick("front", OUTLINE[:3].copy())
    piece = replace(notched_piece(), nicks=(nick,), fold=Fold(OUTLINE[0], OUTLINE[1]))
    ring = np.concatenate([SQUARE, SQUARE[:1], (0.4 * SQUARE + 30.0)[[0, 3, 2, 1, 0]]])
    content = PieceFile("letters", "38", {"cloth": cloth(rotations=None)},
                        {"f": piece, "ring_cloth": plain_piece(ring, cloth(allowance=6.0), name="ring", grain=None)})
    write_pieces(tmp_path / "pieces.json", content)
    return content, tmp_path / "pieces.json"


def test_what_is_read_back_is_drawn_to_the_same_bytes(written, tmp_path):
    content, path = written
    read = read_pieces(path)
    assert list(read.pieces) == ["f", "ring_cloth"]
    assert read.title == "letters · 38" and read.materials == content.materials
    for name, piece in content.pieces.items():
        for kind, made in (("written", piece), ("read", read.pieces[name])):
            write_piece(tmp_path / f"{kind}.svg", made)
        assert (tmp_path / "written.svg").read_bytes() == (tmp_path / "read.svg").read_bytes()
        again = read.pieces[name]
        assert (piece.fold and piece.fold.line.tolist()) == (again.fold and again.fold.line.tolist())
        for a, b in ((piece.sew_line, again.sew_line), (piece.cut_line, again.cut_line),
                     (piece.allowances, again.allowances), *zip(piece.holes, again.holes, strict=True)):
            assert np.array_equal(a, b)  # bit by bit, which the drawing would round


def test_a_seam_runs_its_own_way_with_the_allowances_of_its_edges(written):
    record = json.loads(written[1].read_text())
    front, back = record["pieces"][0]["seams"]
    assert front["vertices"] == [0, 1, 2, 3, 4] and back["vertices"] == [0, 9, 8, 7, 6, 5, 4]
    assert front["allowances"] == [7.5] * 4 and back["allowances"] == [1.0 / 3.0] * 6
    for seam in (front, back):
        steps = np.linalg.norm(np.diff(OUTLINE[seam["vertices"]], axis=0), axis=1)
        assert np.diff(seam["arclengths"]) == pytest.approx(steps, rel=1e-14)


def test_a_notch_points_from_the_cut_line_into_the_piece(written):
    notches = json.loads(written[1].read_text())["pieces"][0]["notches"]
    assert [(n["seam"], n["kind"], n["width"], n["marks"], len(n["lines"])) for n in notches] == [
        ("front", "V", 4.0, 2, 2), ("back", "slit", 0.0, 2, 2)]
    for notch, width in zip(notches, (7.5, 1.0 / 3.0)):
        foot, position, direction = (np.array(notch[key]) for key in ("foot", "position", "direction"))
        assert foot + width * direction == pytest.approx(position, abs=1e-12)


def test_the_docs_name_every_key(written):
    keys = set()

    def walk(value):
        if isinstance(value, dict):
            keys.update(value)
            value = list(value.values())
        for item in value if isinstance(value, list) else []:
            walk(item)

    walk(json.loads(written[1].read_text()))
    assert keys <= set(re.findall(r"`([a-z_]+)`", DOCS.read_text()))


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "flatnet-pieces/0"}', '{"format": "flatnet-pieces/1"}'])
def test_another_file_is_refused(text, tmp_path):
    (tmp_path / "pieces.json").write_text(text)
    with pytest.raises(ValueError):
        read_pieces(tmp_path / "pieces.json")
