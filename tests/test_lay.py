"""`flatnet nest`: pieces of builds and of published problems, laid together."""

import json
from dataclasses import replace

import numpy as np
import pytest
import shapely
from pieces import LETTER_F, SQUARE, cloth, piece
from written import read_report

from flatnet.cli import main
from flatnet.export.drawn_layout import read_layout
from flatnet.export.pieces_json import PieceFile, read_pieces, write_pieces
from flatnet.failure import Finding
from flatnet.lay import LayError, lay
from flatnet.nesting.instance import InstanceError, read_instance
from flatnet.parameters import FINAL_SECONDS, NestingParameters
from flatnet.project.hides import Hide

QUICK = NestingParameters(seconds=1)


def problem(**changes):
    closed = [*LETTER_F.tolist(), LETTER_F[0].tolist()]
    item = {"id": 7, "demand": 3, "allowed_orientations": [0.0, 180.0]}
    item["shape"] = {"type": "simple_polygon", "data": closed}
    return {"name": "letters", "items": [item], "strip_height": 210.0, **changes}


@pytest.fixture
def instance(tmp_path):
    file = tmp_path / "letters.json"
    file.write_text(json.dumps(problem()))
    return file


def test_a_problem_is_read_and_its_strip_is_a_metre_wide_at_least(instance):
    (letter,), material = read_instance(instance)
    assert (letter.name, letter.cut, letter.mirrored) == ("item_7", 3, 0)
    assert (material.name, material.width, material.rotations) == ("letters", 2100.0, (0.0, 180.0))
    assert letter.area == pytest.approx(100.0 * shapely.Polygon(LETTER_F).area, rel=1e-12)


BOW_TIE = [[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("{", "can't be read, line 1"),
        ("flatnet: 1\nname: bag\n", "name the folder that `flatnet build` wrote"),
        ("[]", "no strip packing problem"),
        (json.dumps(problem(strip_height=0)), "'strip_height' must be in"),
        (json.dumps(problem(items=[])), "no items"),
        (json.dumps(problem(items=2 * problem()["items"])), "two of its items have one 'id'"),
        (json.dumps(problem()).replace("180.0", "Infinity"), "must be finite"),
        (json.dumps(problem()).replace(": 3", ": Infinity"), "can't be read"),
        (json.dumps(problem()).replace(": 3", ": -3"), "item_7: 'demand' must be in"),
        (json.dumps({"name": "x", "strip_height": 1}), "KeyError: 'items'"),
        (json.dumps(problem()).replace("simple_polygon", "disk"), "expected a 'simple_polygon', got 'disk'"),
        (json.dumps(problem()).replace("[0.0, 0.0]", "[0.0, NaN]"), "item_7: its outline is not a list"),
        (
            json.dumps(
                problem(items=[{"id": 1, "demand": 1, "shape": {"type": "simple_polygon", "data": BOW_TIE}}])
            ),
            "item_1: its outline is not simple",
        ),
    ],
)
def test_what_is_no_problem_is_told(tmp_path, content, words, capsys):
    file = tmp_path / "bad.json"
    file.write_text(content)
    with pytest.raises(InstanceError, match=words):
        read_instance(file)
    assert main(["nest", str(file), "-o", str(tmp_path / "out")]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_problem_is_laid_written_and_kept(instance, tmp_path, capsys):
    out = tmp_path / "out"
    command = ["nest", str(instance), "-o", str(out), "--seconds", "1"]
    assert main(command) == 0
    said = capsys.readouterr()
    assert "3 pieces on 2100 x" in said.out and "% used" in said.out
    assert "nesting 3 copies for 1 s" in said.err
    (record,) = read_report(out)["layouts"]
    pieces = read_layout(out / record["file"])
    outlines = [shapely.Polygon(drawn.lines["cut"][0]) for drawn in pieces]
    assert len(outlines) == 3
    assert shapely.union_all(outlines).area == pytest.approx(3 * 100.0 * shapely.Polygon(LETTER_F).area, rel=1e-5)
    # Two letters side by side across 210, the third behind them, or better.
    assert record["used_length_mm"] <= 1800.0 + 1.0
    layout = (out / record["file"]).read_bytes()
    assert main(command) == 0
    assert "the layout is unchanged" in capsys.readouterr().err
    assert (out / record["file"]).read_bytes() == layout
    assert main([*command, "--nest-again"]) == 0
    assert "unchanged" not in capsys.readouterr().err


def test_final_is_never_less_than_what_was_asked():
    assert NestingParameters(seconds=5, seed=3).final() == NestingParameters(FINAL_SECONDS, 3)
    assert NestingParameters(seconds=2 * FINAL_SECONDS).final().seconds == 2 * FINAL_SECONDS


def written_build(folder, outline, project, size, material, zone=""):
    folder.mkdir()
    made = replace(piece(outline, material, name="front", cut=1, mirrored=1), zone=zone)
    write_pieces(folder / "pieces.json", PieceFile(project, size, {material.name: material}, {"front": made}))
    return folder


def test_two_sizes_are_laid_together(tmp_path):
    material = cloth(width=450.0, gap=2.0, allowance=5.0)
    builds = [
        written_build(tmp_path / size, factor * LETTER_F, "letters", size, material)
        for size, factor in (("S", 1.0), ("L", 1.4))
    ]
    result = lay(builds, tmp_path / "out", QUICK)
    assert result.exit_status == 0
    (record,) = result.report["layouts"]
    placed = {(entry["patch"], entry["mirrored"]) for entry in record["pieces"]}
    sizes = ("letters · S: front", "letters · L: front")
    assert placed == {(name, mirrored) for name in sizes for mirrored in (False, True)}
    assert result.report["project"] == "letters · S + letters · L"
    # What was read back from the files is what was drawn: the same outline, allowance and all.
    pieces = read_layout(tmp_path / "out" / record["file"])
    (drawn,) = [p.lines["cut"][0] for p in pieces if (p.patch, p.mirrored) == (sizes[1], True)]
    expected = piece(1.4 * LETTER_F, material).area
    assert shapely.Polygon(drawn).area == pytest.approx(expected, rel=1e-5)


def test_a_build_is_not_laid_into_itself(tmp_path, capsys):
    """Its patches, and the certificate, would be gone."""
    build = written_build(tmp_path / "S", LETTER_F, "letters", "S", cloth(width=450.0))
    (build / "report.json").write_text(json.dumps({"format": "flatnet-report/1", "files": ["pieces.json"]}))
    before = (build / "pieces.json").read_bytes()
    assert main(["nest", str(build), "-o", str(tmp_path / "S" / ".." / "S"), "--seconds", "1"]) == 2
    assert "is laid itself" in capsys.readouterr().err
    assert (build / "pieces.json").read_bytes() == before


TWO_DIMENSIONAL = "svg,dxf,dxf-astm,dxf-aama,pdf,pdf-a4,hpgl,cutlist"


def test_a_layout_of_two_builds_is_exported_in_two_dimensions(tmp_path, capsys):
    """Seams of one name and number in both builds stay apart; what needs meshes is refused, and so is verify."""
    material = cloth(width=450.0, gap=2.0, allowance=5.0)
    builds = [
        written_build(tmp_path / size, factor * LETTER_F, "letters", size, material)
        for size, factor in (("S", 1.0), ("L", 1.4))
    ]
    out = tmp_path / "out"
    lay(builds, out, QUICK)
    content = read_pieces(out / "pieces.json")
    assert content.project == "letters · S + letters · L"
    for size, factor in (("S", 1.0), ("L", 1.4)):
        name = f"letters · {size}"
        (written,) = [each for each in content.pieces.values() if each.name == f"{name}: front"]
        assert np.array_equal(written.cut_line, piece(factor * LETTER_F, material, name="front").cut_line)
        assert [run.seam.name for run in written.seams] == [f"{name}: seam_{i}" for i in range(len(LETTER_F))]
        assert {patch for run in written.seams for patch in run.seam.patches} == {f"{name}: front"}
    assert main(["export", str(out), "--format", TWO_DIMENSIONAL]) == 0
    exported = {file for file in read_report(out)["files"] if file.startswith("exports/")}
    assert {"exports/layout-cloth-a4.pdf", "exports/layout-cloth.plt", "exports/pattern-astm.dxf"} <= exported
    placed = [(p.patch, p.linear.tolist(), p.shift.tolist()) for p in read_layout(out / "layout-cloth.svg")]
    layers = read_layout(out / "exports" / "layout-cloth.svg")
    assert all((p.patch, p.linear.tolist(), p.shift.tolist()) in placed for p in layers if "cut" in p.lines)
    rows = (out / "exports" / "cut-list.csv").read_text(encoding="utf-8-sig").splitlines()
    assert [row.split(",")[1:5] for row in rows[1:]] == [[f"letters · {s}: front", "cloth", "1", "1"] for s in "SL"]
    capsys.readouterr()
    assert main(["export", str(out), "--format", "dxf,glb,sewing"]) == 2
    assert "has no meshes and no sewing to write as glb, sewing; export that from each" in capsys.readouterr().err
    assert main(["verify", str(out)]) == 2
    assert "verify those that it was made of" in capsys.readouterr().err
    assert not (out / "certificate.json").exists()


def test_a_layout_of_a_problem_is_exported_too(instance, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["nest", str(instance), "-o", str(out), "--seconds", "1"]) == 0
    assert main(["export", str(out), "--format", TWO_DIMENSIONAL]) == 0
    # what a version wrote that kept no pieces
    report = read_report(out)
    report["files"].remove("pieces.json")
    (out / "report.json").write_text(json.dumps(report))
    capsys.readouterr()
    assert main(["export", str(out), "--format", "pdf-a4"]) == 2
    assert "run `flatnet nest` again" in capsys.readouterr().err


def test_builds_of_different_materials_of_one_name_are_refused(tmp_path):
    first = written_build(tmp_path / "a", SQUARE, "a", "", cloth(width=450.0))
    second = written_build(tmp_path / "b", SQUARE, "b", "", cloth(width=460.0))
    words = "its material 'cloth' is another than that of .*a: width 460 mm and not 450 mm; .*`--materials FILE`"
    with pytest.raises(LayError, match=words):
        lay([first, second], tmp_path / "out", QUICK)
    free = replace(cloth(width=450.0), rotations=None, hides=(Hide(((0, 0), (9, 0), (9, 8)), (), ()),))
    third = written_build(tmp_path / "c", SQUARE, "c", "", free)
    words = r"rotations free and not \[0.0, 180.0\], hides \[9 x 8 mm\] and not \[\];"
    with pytest.raises(LayError, match=words):
        lay([first, third], tmp_path / "out", QUICK)
    assert not (tmp_path / "out").exists()


def test_a_folder_without_pieces_is_told(tmp_path, capsys):
    assert main(["nest", str(tmp_path), "-o", str(tmp_path / "out")]) == 2
    assert "name the output folder of a build" in capsys.readouterr().err


def test_a_piece_that_does_not_fit_fails_and_the_others_are_laid(tmp_path):
    material = cloth(width=120.0)
    builds = [
        written_build(tmp_path / "small", SQUARE, "small", "", material),
        written_build(tmp_path / "large", np.array(2.0 * SQUARE), "large", "", material),
    ]
    result = lay(builds, tmp_path / "out", QUICK)
    assert result.exit_status == 1 and result.report["status"] == "partial"
    (finding,) = result.report["findings"]
    assert (finding["code"], finding["patch"]) == ("sheet_too_small", "large: front")
    assert "missing large: front" in (tmp_path / "out" / "layout-cloth.svg").read_text()


def test_a_build_with_a_patch_that_failed_is_laid_and_called_incomplete(tmp_path, capsys):
    material = cloth(width=450.0)
    build = written_build(tmp_path / "bag", SQUARE, "bag", "", material)
    failure = Finding("folded", "unfold", "It folds back.", "Cut it.", patch="base")
    not_laid = Finding("sheet_too_small", "nesting", "It was too large.", "Take another.", patch="front")
    records = [{"name": f.patch, "status": "failed", "failure": f.as_dict()} for f in (failure, not_laid)]
    (build / "report.json").write_text(json.dumps({"patches": records}))
    assert main(["nest", str(build), "-o", str(tmp_path / "out"), "--seconds", "1"]) == 1
    said = capsys.readouterr().out
    assert "base: FAILED folded: It folds back. Cut it." in said and "partial: " in said
    assert "front: FAILED" not in said  # its piece is there, and has room now
    assert "INCOMPLETE: missing base" in (tmp_path / "out" / "layout-cloth.svg").read_text()
    other = written_build(tmp_path / "purse", SQUARE, "purse", "", material)
    result = lay([other, build], tmp_path / "both", QUICK)
    assert result.exit_status == 1
    assert "missing bag: base" in (tmp_path / "both" / "layout-cloth.svg").read_text()
    (build / "report.json").write_text("[]")
    with pytest.raises(LayError, match="not the report of a build"):
        lay([build], tmp_path / "out", QUICK)


def test_a_material_that_a_problem_does_not_have_is_told(instance, tmp_path, capsys):
    (tmp_path / "felt.yaml").write_text("materials: {felt: {width: 9}}")
    command = ["nest", str(instance), "-o", str(tmp_path / "out"), "--materials", str(tmp_path / "felt.yaml")]
    assert main(command) == 2
    assert "no piece is cut from material 'felt'; the pieces' materials are 'letters'" in capsys.readouterr().err


def test_other_materials_take_the_place_of_those_of_the_build(tmp_path, capsys):
    build = written_build(tmp_path / "out", SQUARE, "square", "", cloth(width=450.0))
    hide = tmp_path / "hide.yaml"
    outline = "[[0, 0], [30, 0], [30, 20], [0, 20]]"
    hide.write_text(f"units: cm\nmaterials: {{cloth: {{rotations: free, hides: {{outline: {outline}}}}}}}\n")
    assert main(["nest", str(build), "-o", str(tmp_path / "laid"), "--seconds", "1", "--materials", str(hide)]) == 0
    (record,) = read_report(tmp_path / "laid")["layouts"]
    assert record["hide"]["outline"] == [[0, 0], [300, 0], [300, 200], [0, 200]]
    assert record["utilisation"] == pytest.approx(2e4 / 6e4, rel=1e-9)
    text = (tmp_path / "laid" / record["file"]).read_text()
    assert 'class="sheet"' in text and "M 0.0,200.0 300.0,200.0 300.0,0.0 0.0,0.0 Z" in text
    hide.write_text("materials: {cloth: {width: wide}, felt: {width: 9}}")
    assert main(["nest", str(build), "-o", str(tmp_path / "laid"), "--materials", str(hide)]) == 2
    assert "hide.yaml:1:28: material 'cloth': width: expected a number" in capsys.readouterr().err
    zoned = replace(cloth(width=450.0), hides=(Hide(((0, 0), (9, 0), (9, 9)), (), (("A", ((0, 0), (9, 0), (9, 9))),)),))
    of_leather = written_build(tmp_path / "leather", SQUARE, "bag", "", zoned, zone="A")
    hide.write_text("materials: {cloth: {width: 450}}")
    assert main(["nest", str(of_leather), "-o", str(tmp_path / "bag"), "--materials", str(hide)]) == 2
    assert "bag: piece 'front' asks for zone 'A', which no hide of material 'cloth' has" in capsys.readouterr().err
    hide.write_text("materials: {felt: {width: 9}}")
    assert main(["nest", str(build), "-o", str(tmp_path / "laid"), "--materials", str(hide)]) == 2
    assert "no piece is cut from material 'felt'" in capsys.readouterr().err
