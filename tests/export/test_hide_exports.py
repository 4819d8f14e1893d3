"""What is laid on a hide is exported on the hide: its own outline, its number, its area. The first one stays empty."""

import csv
import json
import shutil

import ezdxf
import numpy as np
import pypdf
import pytest
from golden import same_lines
from svgelements import SVG, Text
from svgelements import Path as SvgPath
from test_golden import pdf_lines
from written import READER_SCALE

from flatnet.cli import main
from flatnet.report.summary import summary_lines
from flatnet.verify.verify import verify

SMALL = [[0, 0], [90, 0], [90, 90], [0, 90]]
OUTLINE = [[0, 0], [500, 60], [450, 410], [30, 380]]
DEFECT, ZONE = [[40, 40], [60, 40], [50, 60]], [[100, 80], [420, 80], [420, 370], [100, 370]]
PROJECT = f"""
flatnet: 1
name: tray
edge_length: 50
nodes: {{a: [0, 0, 0], b: [200, 0, 0], c: [200, 200, 0], d: [0, 200, 0]}}
curves:
  south: {{from: a, to: b, normals: [0, 0, 1]}}
  east: {{from: b, to: c, normals: [0, 0, 1]}}
  north: {{from: c, to: d, normals: [0, 0, 1]}}
  west: {{from: d, to: a, normals: [0, 0, 1]}}
patches: {{tray: {{around: [south, east, north, west], zone: A}}}}
rest: openings
materials:
  leather: {{hides: [{{outline: {SMALL}}}, {{outline: {OUTLINE}, defects: [{DEFECT}], zones: {{A: {ZONE}}}}}]}}
nesting: {{seconds: 1}}
"""
#: What is drawn of the second hide: its outline, defect and zone, (k, 2) mm, y up.
RINGS = [np.array(ring, float) for ring in (OUTLINE, DEFECT, ZONE)]


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """A build with a sheet on the second of two hides, and its exports."""
    folder = tmp_path_factory.mktemp("hides")
    (folder / "project.yaml").write_text(PROJECT)
    assert main(["build", str(folder / "project.yaml"), "-o", str(folder / "out")]) == 0
    assert main(["export", str(folder / "out"), "--format", "svg,dxf,pdf,pdf-a4,hpgl,cutlist"]) == 0
    return folder / "out"


def test_the_only_layout_is_on_the_second_hide(out):
    (layout,) = json.loads((out / "report.json").read_text())["layouts"]
    assert (layout["file"], layout["sheet"]) == ("layout-leather-2.svg", 2)


def test_dxf_has_the_rims_of_the_hide(out):
    page = ezdxf.readfile(out / "exports" / "layout-leather-2.dxf").modelspace()
    lines = page.query('LWPOLYLINE[layer=="sheet"]')
    assert all(line.closed for line in lines)
    same_lines([np.array(list(line.vertices())) for line in lines], RINGS, 1e-9)
    (title,) = [text.dxf.text for text in page.query("TEXT") if "hide 2" in text.dxf.text]
    assert "410 x 500.0 mm" in title


def test_svg_has_the_rims_of_the_hide(out):
    svg = SVG.parse(str(out / "exports" / "layout-leather-2.svg"), ppi=25.4)
    paths = [e for e in svg.elements() if isinstance(e, SvgPath) and e.values["class"] in ("sheet", "defect", "zone")]
    found = [np.array([[s.end.x, s.end.y] for s in path][:-1]) / READER_SCALE for path in paths]
    same_lines(found, [ring * [1.0, -1.0] + [0.0, 410.0] for ring in RINGS], 0.002)


def test_svg_names_the_zone_inside_it_and_fills_the_defect(out):
    for file in (out / "layout-leather-2.svg", out / "exports" / "layout-leather-2.svg"):
        svg = SVG.parse(str(file), ppi=25.4)
        (words,) = [e for e in svg.elements() if isinstance(e, Text) and e.text == "zone A"]
        x, y = np.array([words.transform.e, words.transform.f]) / READER_SCALE
        assert 100.0 < x < 420.0 and 80.0 < 410.0 - y < 370.0
        linear = np.array([[words.transform.a, words.transform.c], [words.transform.b, words.transform.d]])
        assert np.linalg.det(linear) > 0.0  # not mirrored
        filled = [e.values["class"] for e in svg.elements() if isinstance(e, SvgPath) and e.fill.value is not None]
        assert filled == ["defect"]


def test_the_terminal_has_the_size_of_the_hide(out):
    report = json.loads((out / "report.json").read_text())
    assert any("1 piece on a hide of 410 x 500 mm, " in line for line in summary_lines(report, out))


def test_pdf_has_the_rims_of_the_hide_on_its_page_and_on_every_tile(out):
    grey = (0x88 / 255,) * 3
    (page,) = pypdf.PdfReader(out / "exports" / "layout-leather-2.pdf").pages
    colour = next(colour for colour in pdf_lines(page) if np.allclose(colour, grey, atol=1e-3))
    found = pdf_lines(page)[colour]
    shift = found[0].min(axis=0)
    same_lines([line - shift for line in found], RINGS, 0.001)
    _, *tiles = pypdf.PdfReader(out / "exports" / "layout-leather-2-a4.pdf").pages
    for tile in tiles:
        outline = next(line for line in pdf_lines(tile)[colour] if np.ptp(line, axis=0).max() > 499.0)
        assert np.abs(np.ptp(outline, axis=0) - [500.0, 410.0]).max() < 0.001


def test_the_material_list_counts_the_whole_hide(out):
    (row,) = csv.DictReader((out / "exports" / "materials.csv").open(encoding="utf-8-sig"))
    x, y = RINGS[0].T
    area = 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert float(row["area_m2"]) == pytest.approx(1e-6 * area, abs=5e-4)
    assert (row["sheet"], row["width_mm"]) == ("2", "410")
    assert float(row["used_percent"]) == pytest.approx(100.0 * 40_000.0 / area, abs=0.05)


def test_build_and_exports_are_verified_and_a_sheet_that_is_used_twice_is_not(out, tmp_path):
    assert [str(problem) for problem in verify(out).problems] == []
    twice = shutil.copytree(out, tmp_path / "out")
    report = json.loads((twice / "report.json").read_text())
    report["layouts"] *= 2
    (twice / "report.json").write_text(json.dumps(report))
    assert "every sheet once" in {problem.check for problem in verify(twice).problems}
