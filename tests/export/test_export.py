"""The command `flatnet export`, and what a build exports by itself; notches, marks and letters of a small project."""

import hashlib
import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import ezdxf
import jsonschema
import numpy as np
import pypdf
import pytest

from flatnet.cli import main
from flatnet.parameters import EXPORT_FORMATS

SCHEMA = Path(__file__).parents[2] / "docs" / "sewing.schema.json"
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
    assert np.linalg.norm(pair[0] - pair[1]) == pytest.approx(6.0)
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
    digest = hashlib.sha256((out / "report.json").read_bytes()).hexdigest()
    certificate = {
        "project": "square", "passed": True, "problems": [], "sha256": {"report.json": digest},
        "checks": [{"check": "edge lengths", "things": 7, "failed": 0, "worst": 1e-9, "allowed": 1e-6, "unit": "mm"}],
    }
    (out / "certificate.json").write_text(json.dumps(certificate))
    try:
        assert main(arguments) == 0
    finally:
        (out / "certificate.json").unlink()
    text = pypdf.PdfReader(tmp_path / "layout-cloth-a4.pdf").pages[-1].extract_text()
    assert "all checks passed" in text and "edge lengths: 7 checked, ok; worst 1e-09 of 1e-06 mm" in text
    assert f"{digest}  report.json" in text


def test_a_certificate_of_other_files_is_not_printed(out, tmp_path, capsys):
    """Nor where the export itself would make it one, or where there is no page to print it on."""
    copy = shutil.copytree(out, tmp_path / "copy")
    arguments = ["export", str(copy), "--certificate", "--format"]
    assert main(["verify", str(copy)]) == 0
    assert main([*arguments, "pdf-a4", "-o", str(tmp_path / "pdf")]) == 0
    capsys.readouterr()
    assert main([*arguments, "pdf-a4"]) == 2
    assert "name a folder outside it with -o" in capsys.readouterr().err
    assert main([*arguments, "dxf", "-o", str(tmp_path / "dxf")]) == 2
    assert "a certificate is printed at the end of PDFs" in capsys.readouterr().err
    assert export(copy, "cutlist") == 0
    assert "certificate.json is older than these files" in capsys.readouterr().out
    assert main([*arguments, "pdf-a4", "-o", str(tmp_path / "stale")]) == 2
    assert "report.json changed since); run `flatnet verify" in capsys.readouterr().err
    assert not (tmp_path / "stale").exists() and not (tmp_path / "dxf").exists()
    assert main(["verify", str(copy)]) == 0
    assert main([*arguments, "pdf-a4", "-o", str(tmp_path / "fresh")]) == 0


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


FOLDED = """
flatnet: 1
name: folded
edge_length: 25
nodes: {a: [0, 0, 0], b: [100, 0, 0], c: [100, 200, 0], d: [0, 180, 0], e: [160, 0, 0], f: [150, 200, 0]}
curves:
  middle: {from: d, to: a, normals: [0, 0, 1]}
  hem: {from: a, to: b, normals: [0, 0, 1], allowance: 12, notches: {at: [30]}}
  side: {from: b, to: c, normals: [0, 0, 1]}
  top: {from: c, to: d, normals: [0, 0, 1]}
  foot: {from: b, to: e, normals: [0, 0, 1]}
  edge: {from: e, to: f, normals: [0, 0, 1]}
  head: {from: f, to: c, normals: [0, 0, 1]}
patches:
  back: {around: [hem, side, top, middle], fold: middle, allowance: 5}
  flank: {around: [foot, edge, head, -side], mirrored: 1}
rest: openings
nesting: {seconds: 1}
"""


def test_a_piece_on_the_fold_is_sewn_on_both_its_halves(tmp_path):
    (tmp_path / "project.yaml").write_text(FOLDED)
    out = tmp_path / "out"
    assert main(["build", str(tmp_path / "project.yaml"), "-o", str(out)]) == 0
    assert export(out, "sewing", "garmentcode", "dxf-astm") == 0
    pieces = {piece["name"]: piece for piece in json.loads((out / "pieces.json").read_text())["pieces"]}
    record = json.loads((out / "exports" / "sewing.json").read_text())
    jsonschema.validate(record, json.loads(SCHEMA.read_text()))
    start, end = np.array(pieces["back"]["fold"])
    across = np.array([[0, 1], [-1, 0]]) @ (end - start) / np.linalg.norm(end - start)
    assert {seam["name"]: seam["kind"] for seam in record["seams"] if seam["kind"] != "opening"} == {
        "middle": "fold", "side": "seam"}
    for seam in record["seams"]:
        for side in seam["sides"] if seam["kind"] != "fold" else []:
            (on_piece,) = side["pieces"]
            points = np.array(pieces[on_piece["name"]]["sew_line"])
            along = points[on_piece["vertices"]]
            lengths = np.linalg.norm(np.diff(along, axis=0), axis=1)
            assert np.diff(side["arclengths"]) == pytest.approx(lengths, abs=1e-9)
            assert (on_piece["image"] is None) == (side["patch"] == "flank")
            if on_piece["image"]:
                mirrored = along - 2.0 * ((along - start) @ across)[:, None] * across
                assert np.abs(points[on_piece["image"]] - mirrored).max() < 1e-9
    panels = json.loads((out / "exports" / "folded_specification.json").read_text())["pattern"]
    stitches = panels["stitches"]
    (joined,) = [seam for seam in record["seams"] if len(seam["sides"]) == 2]
    assert len(stitches) == len(joined["sides"][0]["vertices"]) - 1
    for stitch in stitches:
        lengths = []
        for side in stitch:
            vertices = np.array(panels["panels"][side["panel"]]["vertices"])
            lengths.append(np.linalg.norm(vertices[(side["edge"] + 1) % len(vertices)] - vertices[side["edge"]]))
        assert lengths[0] == pytest.approx(lengths[1], abs=1e-9)
    block = ezdxf.readfile(out / "exports" / "pattern-astm.dxf").blocks.get("back_ONE")
    assert len(block.query('POINT[layer=="4"]')) == 2


def test_nicks_are_cut_like_the_outline_and_are_notches_in_the_trades_dxf(tmp_path):
    from pieces import SQUARE, cloth, piece

    from flatnet.export.dxf_pattern import ASTM, write_dxf_pattern
    from flatnet.export.hpgl import write_hpgl
    from flatnet.export.pieces_json import PieceFile
    from flatnet.nesting import Layout, Placement
    from flatnet.pattern.nicks import Nick

    wedge = Nick("seam_0", np.array([[48.0, -10.0], [50.0, -3.0], [52.0, -10.0]]))
    slit = Nick("seam_1", np.array([[110.0, 30.0], [104.0, 30.0]]))
    made = replace(piece(SQUARE, cloth(allowance=10.0), name="p"), nicks=(wedge, slit))
    write_dxf_pattern(tmp_path / "p.dxf", PieceFile("p", "", {"cloth": cloth()}, {"p": made}), ASTM)
    points = ezdxf.readfile(tmp_path / "p.dxf").blocks.get("p_ONE").query('POINT[layer=="4"]')
    said = [(*p.dxf.location.xyz, p.dxf.thickness, p.dxf.angle) for p in points]
    assert said == [pytest.approx((50, -10, 7, 4, 90)), pytest.approx((110, 30, 6, 0, 180))]
    write_hpgl(tmp_path / "p.plt", Layout(cloth(), (Placement(made, 1, False, 0.0, 10.0, 10.0),)))
    pens = (tmp_path / "p.plt").read_text().split("SP1;")
    assert "PU2320,0;PD2400,280,2480,0" in pens[1]
