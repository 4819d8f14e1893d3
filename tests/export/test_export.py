"""The command `flatnet export`, and what a build exports by itself; notches, marks and letters of a small project."""

import json
import sys

import ezdxf
import numpy as np
import pypdf
import pytest

from flatnet.cli import main
from flatnet.parameters import EXPORT_FORMATS

PROJECT = """
flatnet: 1
name: Größe 裤子 брюки
size: 38 ½
edge_length: 25
nodes: {a: [0, 0, 0], b: [200, 0, 0], c: [200, 200, 0], d: [0, 200, 0]}
curves:
  süd: {from: a, to: b, normals: [0, 0, 1], notches: {at: [50], kind: T, marks: 2, depth: 3}}
  east: {from: b, to: c, normals: [0, 0, 1], notches: {at: [60], kind: castle}, allowance: 6}
  north: {from: c, to: d, normals: [0, 0, 1], notches: {at: [70], kind: V}}
  west: {from: d, to: a, normals: [0, 0, 1], notches: {at: [80]}}
patches:
  рукав: {around: [süd, east, north, west], material: cloth, cut: 1, mirrored: 1, grain: [0, 1, 0],
    also: {lining: {cut: 2, allowance: 1}},
    marks: {pocket: {points: [[50, 50, 0], [90, 50, 0], [90, 90, 0]], kind: stitch},
      eye: {at: [120, 120, 0], kind: eyelet, diameter: 4}}}
rest: openings
materials: {cloth: {width: 500, allowance: 10}, lining: {width: 400, rotations: free}}
nesting: {seconds: 1}
"""


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """A build of a square with notches and marks and names in several alphabets."""
    folder = tmp_path_factory.mktemp("square")
    (folder / "project.yaml").write_text(PROJECT, encoding="utf-8")
    assert main(["build", str(folder / "project.yaml"), "-o", str(folder / "out")]) == 0
    return folder / "out"


def export(out, *formats, to=None):
    return main(["export", str(out), "--format", ",".join(formats), *(["-o", str(to)] if to else [])])


def test_every_kind_of_notch_and_mark_is_on_its_layer(out, tmp_path):
    assert export(out, "dxf-astm", "dxf-aama", to=tmp_path) == 0
    astm, aama = (
        {block.name: block for block in ezdxf.readfile(tmp_path / f"pattern-{name}.dxf").blocks if block.name[0] != "*"}
        for name in ("astm", "aama")
    )
    assert list(astm) == list(aama) == ["rukav_38_1_2", "rukav_lining_38_1_2"]
    block = astm["rukav_38_1_2"]
    points = {
        layer: sorted((p.dxf.location.z, p.dxf.thickness, round(p.dxf.angle, 6)) for p in block.query(
            f'POINT[layer=="{layer}"]'))
        for layer in (4, 13, 80, 81)
    }
    # The grain runs along y: the piece is turned by -90 degrees, so that its south side faces left.
    assert points == {4: [(4.0, 0.0, 270.0), (4.0, 4.0, 180.0)], 13: [(0.0, 0.0, 0.0)],
                      80: [(3.0, 4.0, 0.0)] * 2, 81: [(4.0, 4.0, 90.0)]}
    pair = [np.array(p.dxf.location.vec2) for p in block.query('POINT[layer=="80"]')]
    assert np.linalg.norm(pair[0] - pair[1]) == pytest.approx(4.0)
    (cut,) = block.query('POLYLINE[layer=="1"]')
    x = np.array([v.dxf.location.x for v in cut.vertices])
    assert [p[0] for p in pair] == pytest.approx([x.min()] * 2, abs=1e-9)
    assert len(block.query('POLYLINE[layer=="8"]')) == 2 and len(block.query('POLYLINE[layer=="85"]')) == 2
    corners = {tuple(v.dxf.location.vec2) for v in cut.vertices}
    turns = {tuple(p.dxf.location.vec2) for p in block.query('POINT[layer=="2"]')}
    assert len(turns) == 8 and len(turns & corners) == 4  # of cut and sew line
    old = aama["rukav_38_1_2"]
    assert len(old.query('POINT[layer=="4"]')) == 5
    assert max(int(entity.dxf.layer) for entity in old) == 14


def test_letters_are_transliterated_where_there_are_seven_bits_and_that_is_said(out, tmp_path, capsys):
    assert export(out, "dxf-astm", "hpgl", "pdf", "dxf", to=tmp_path) == 0
    said = capsys.readouterr().out
    assert "pattern-astm.dxf: the format has 7-bit letters only; 'рукав' is written 'rukav'" in said
    for file in [tmp_path / "pattern-astm.dxf", *tmp_path.glob("*.plt")]:
        assert b"rukav" in file.read_bytes() and file.read_bytes().isascii()
    (page,) = pypdf.PdfReader(tmp_path / "layout-cloth.pdf").pages
    text = page.extract_text()
    assert "рукав" in text and "süd" in text
    texts = [t.dxf.text for t in ezdxf.readfile(tmp_path / "layout-cloth.dxf").modelspace().query("TEXT")]
    assert "рукав" in texts and any("Größe 裤子 брюки · 38 ½" in each for each in texts)


def test_each_material_has_its_own_drawing_and_each_piece_its_allowances(out, tmp_path):
    assert export(out, "dxf", "sewing", to=tmp_path) == 0
    assert {file.name for file in tmp_path.iterdir()} == {"layout-cloth.dxf", "layout-lining.dxf", "sewing.json"}
    seams = json.loads((tmp_path / "sewing.json").read_text())["seams"]
    (side,) = next(seam for seam in seams if seam["name"] == "east")["sides"]
    said = {piece["material"]: set(piece["allowances"]) for piece in side["pieces"]}
    assert said == {"cloth": {6.0}, "lining": {1.0}}
    assert {seam["kind"] for seam in seams} == {"opening"}


def test_the_same_build_gives_the_same_bytes(out, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    for folder in ("a", "b"):
        assert export(out, *EXPORT_FORMATS, to=tmp_path / folder) == 0
    files = [file.relative_to(tmp_path / "a") for file in (tmp_path / "a").rglob("*") if file.is_file()]
    assert len(files) > 20
    assert [f for f in files if (tmp_path / "a" / f).read_bytes() != (tmp_path / "b" / f).read_bytes()] == []
    assert "Creation Date: 09-09-2001" in (tmp_path / "a" / "pattern-astm.dxf").read_text()


def test_colours_of_the_project_are_those_of_every_drawing(tmp_path):
    text = PROJECT + "strokes: {cut: '#0A0B0C'}\nexports: [svg, dxf]\n"
    (tmp_path / "project.yaml").write_text(text, encoding="utf-8")
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(tmp_path / "out")]) == 0
    for file in ("layout-cloth.svg", "exports/layout-cloth.svg", "exports/pieces/piece.svg", "pieces/piece.svg"):
        text = (tmp_path / "out" / file).read_text()
        assert 'stroke="#0a0b0c"' in text and "#ff0000" not in text
    document = ezdxf.readfile(tmp_path / "out" / "exports" / "layout-cloth.dxf")
    assert document.layers.get("cut").rgb == (10, 11, 12) and document.layers.get("sew").rgb == (0, 0, 255)


def test_what_is_exported_into_a_build_goes_with_it(tmp_path):
    """By the project, then by hand: both are files of the build, and the next one removes what it does not write."""
    project, out = tmp_path / "project.yaml", tmp_path / "out"
    project.write_text(PROJECT + "exports: [cutlist]\n", encoding="utf-8")
    assert main(["build", str(project), "-o", str(out)]) == 0
    assert export(out, "hpgl") == 0

    def listed():
        return set(json.loads((out / "report.json").read_text())["files"])

    def written():
        return {file.relative_to(out).as_posix() for file in out.rglob("*") if file.is_file()}

    assert written() == listed() >= {"exports/cut-list.csv", "exports/layout-cloth.plt"}
    project.write_text(PROJECT, encoding="utf-8")
    assert main(["build", str(project), "-o", str(out)]) == 0
    assert written() == listed() and not (out / "exports").exists()


def test_a_patch_that_is_missing_is_said(out, tmp_path, capsys):
    copy = tmp_path / "out"
    copy.mkdir()
    for name in ("report.json", "pieces.json"):
        (copy / name).write_bytes((out / name).read_bytes())
    report = json.loads((copy / "report.json").read_text())
    report["patches"].append({"name": "collar", "status": "failed"})
    (copy / "report.json").write_text(json.dumps(report))
    assert export(copy, "pdf-a4") == 0
    pages = pypdf.PdfReader(copy / "exports" / "layout-cloth-a4.pdf").pages
    assert all("INCOMPLETE: missing collar" in page.extract_text() for page in pages)


def test_the_certificate_is_the_last_page(out, tmp_path, capsys):
    arguments = ["export", str(out), "--format", "pdf-a4", "-o", str(tmp_path), "--certificate"]
    if not (out / "certificate.json").exists():
        assert main(arguments) == 2
        assert "flatnet verify" in capsys.readouterr().err
    certificate = {
        "project": "square", "passed": True, "problems": [], "sha256": {"report.json": "0123abcd"},
        "checks": [{"check": "edge lengths", "things": 7, "failed": 0, "worst": 1e-9, "allowed": 1e-6, "unit": "mm"}],
    }
    (out / "certificate.json").write_text(json.dumps(certificate))
    try:
        assert main(arguments) == 0
    finally:
        (out / "certificate.json").unlink()
    text = pypdf.PdfReader(tmp_path / "layout-cloth-a4.pdf").pages[-1].extract_text()
    assert "all checks passed" in text and "edge lengths: 7 checked, ok; worst 1e-09 of 1e-06 mm" in text
    assert "0123abcd  report.json" in text


@pytest.mark.parametrize("name", ["ezdxf", "reportlab", "anyascii", "pygltflib"])
def test_a_missing_library_is_named_and_nothing_is_written(name, out, tmp_path, monkeypatch, capsys):
    for module in [module for module in sys.modules if module.split(".")[0] == name]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, name, None)
    assert export(out, *EXPORT_FORMATS, to=tmp_path / "to") == 2
    assert f"needs {name}, which is not installed: pip install 'flatnet[exports]'" in capsys.readouterr().err
    assert not (tmp_path / "to").exists()
    project = tmp_path / "project.yaml"
    project.write_text(PROJECT + f"exports: [{', '.join(EXPORT_FORMATS)}]\n", encoding="utf-8")
    assert main(["build", str(project), "-o", str(tmp_path / "out")]) == 2
    assert not (tmp_path / "out").exists()


def test_a_folder_without_a_build_is_refused(tmp_path, capsys):
    assert export(tmp_path, "dxf") == 2
    assert "holds no report.json of a build" in capsys.readouterr().err


@pytest.mark.parametrize(("file", "text"), [("pieces.json", "{}"), ("report.json", "[]"), ("pieces.json", None)])
def test_a_damaged_build_is_refused(file, text, out, tmp_path, capsys):
    for name in ("report.json", "pieces.json"):
        (tmp_path / name).write_bytes((out / name).read_bytes())
    (tmp_path / file).unlink()
    if text is not None:
        (tmp_path / file).write_text(text)
    assert export(tmp_path, "dxf") == 2
    assert "build again" in capsys.readouterr().err
    assert not (tmp_path / "exports").exists()


def test_a_target_that_is_a_file_is_an_error(out, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert export(out, "cutlist", to=tmp_path / "file") == 2
    assert "can't be written" in capsys.readouterr().err


def test_an_unknown_format_is_an_error(tmp_path, capsys):
    with pytest.raises(SystemExit):
        export(tmp_path, "dxf", "pfd")
    assert "unknown format 'pfd'" in capsys.readouterr().err


def test_names_that_are_alike_in_seven_bits_are_blocks_of_their_own(tmp_path):
    from pieces import SQUARE, cloth, piece

    from flatnet.export.dxf_pattern import ASTM, write_dxf_pattern
    from flatnet.export.pieces_json import PieceFile

    pieces = {file: piece(SQUARE, cloth(), name=name) for file, name in (("a", "für"), ("b", "fur"), ("c", "Fur"))}
    write_dxf_pattern(tmp_path / "p.dxf", PieceFile("p", "", {"cloth": cloth()}, pieces), ASTM)
    names = [block.name for block in ezdxf.readfile(tmp_path / "p.dxf").blocks if block.name[0] != "*"]
    assert names == ["fur_ONE", "fur_ONE-2", "Fur_ONE-3"]
