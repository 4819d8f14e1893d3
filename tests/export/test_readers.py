"""Programs that aren't ours open the exports and find them in true size; one that is not installed skips, loudly."""

import json
import re
import shutil
import struct
import subprocess
import warnings
from pathlib import Path

import numpy as np
import pytest
from golden import same_lines

READERS = Path(__file__).parent / "readers"
DXF_INPUT = Path("/usr/share/inkscape/extensions/dxf_input.py")
SYSTEM_PYTHON = Path("/usr/bin/python3")


def run(*command):
    """What a program prints; the test is skipped where it is not installed."""
    if shutil.which(str(command[0])) is None:
        absent(str(command[0]))
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


def absent(name):
    warnings.warn(f"{name} is not installed: what it reads is not tested", stacklevel=2)
    pytest.skip(f"{name} is not installed")


@pytest.fixture
def extent(golden):
    """Width and height of all that is cut on the sheet, mm."""
    points = np.concatenate(list(golden.cut_lines.values()))
    return np.ptp(points, axis=0)


def test_hp2xx_finds_the_true_size(golden, extent, tmp_path):
    said = run("hp2xx", "-m", "svg", "-f", tmp_path / "x.svg", "-t", golden.folder / f"{golden.sheet}.plt")
    width, height = map(float, re.search(r"([\d.]+) x ([\d.]+) mm, true sizes", said).groups())
    assert (width, height) == pytest.approx(tuple(extent), abs=0.025 + 0.01)  # two half units, and what it prints


def test_pdfinfo_finds_the_page_sizes(golden):
    for paper, (width, height) in {"a4": (210, 297), "letter": (215.9, 279.4)}.items():
        said = run("pdfinfo", golden.folder / f"{golden.sheet}-{paper}.pdf")
        size = [float(each) * 25.4 / 72 for each in re.search(r"Page size: +([\d.]+) x ([\d.]+)", said).groups()]
        assert sorted(size) == pytest.approx([width, height], abs=0.01)


def test_pdftoppm_shows_the_test_square(golden, tmp_path):
    """On the first page of the tiles: a frame of 50 mm, dark on white, at 254 dots to the inch, 10 to the mm."""
    run("pdftoppm", "-r", "254", "-l", "1", "-gray", golden.folder / f"{golden.sheet}-a4.pdf", tmp_path / "page")
    (file,) = tmp_path.glob("page*")
    header = re.match(rb"P5\s+(\d+)\s+(\d+)\s+255\s", file.read_bytes())
    width, height = int(header[1]), int(header[2])
    dark = np.frombuffer(file.read_bytes()[header.end() :], np.uint8).reshape(height, width) < 128
    column = dark[100:610, 95:105].any(axis=1)  # along the square's left side, 10 mm from the page's edge
    row = dark[95:105, 95:610].any(axis=0)
    assert column.sum() == pytest.approx(500, abs=6) and row[:510].sum() == pytest.approx(503, abs=6)


def test_rsvg_convert_finds_the_size_of_layout_and_piece(golden, tmp_path):
    for file in (golden.folder / f"{golden.sheet}.svg", next((golden.folder / "pieces").iterdir())):
        width, height = map(float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', file.read_text()).groups())
        dots = 40.0
        run("rsvg-convert", "-d", dots, "-p", dots, "-o", tmp_path / "x.png", file)
        size = struct.unpack(">II", (tmp_path / "x.png").read_bytes()[16:24])
        assert size == pytest.approx((width * dots / 25.4, height * dots / 25.4), abs=1.0)


def test_inkscape_finds_the_size_of_the_sheet_and_all_layers(golden, extent):
    said = run("inkscape", "--query-all", golden.folder / f"{golden.sheet}.svg")
    boxes = {line.split(",")[0]: [float(n) * 25.4 / 96 for n in line.split(",")[1:]] for line in said.splitlines()
             if re.match(r"[\w-]+(,[-\d.e]+){4}$", line)}
    assert {"cut", "sew", "grain", "text"} <= set(boxes)
    stroke = 0.3
    # At corners the stroke is mitred, up to four times its width (the default limit).
    assert boxes["cut"][2:] == pytest.approx(tuple(extent + stroke), abs=4 * stroke)


def test_inkscapes_dxf_reader_finds_the_lines(golden, extent):
    if not DXF_INPUT.is_file():
        absent("Inkscape's dxf_input.py")
    check = subprocess.run([SYSTEM_PYTHON, "-c", "import lxml, numpy, cssselect"], capture_output=True)
    if check.returncode:
        absent("python3-lxml, python3-numpy or python3-cssselect")
    said = run(SYSTEM_PYTHON, DXF_INPUT, "--scalemethod=manual", "--scale=1.0", golden.folder / f"{golden.sheet}.dxf")
    layer = re.search(r'inkscape:label="cut">(.*?)</g>', said, re.S)[1]
    px = 25.4 / 96
    paths = [np.array(re.findall(r"(-?[\d.]+),(-?[\d.]+)", path), float) for path in re.findall(r' d="([^"]*)"', layer)]
    assert all((path[0] == path[-1]).all() for path in paths)
    found = [path[:-1] * [px, -px] for path in paths]
    shift = np.min([line.min(axis=0) for line in found], axis=0)
    low = np.min([line.min(axis=0) for line in golden.cut_lines.values()], axis=0)
    same_lines([line - shift + low for line in found], list(golden.cut_lines.values()), 0.001)


@pytest.mark.parametrize("dialect", ["astm", "aama"])
def test_dxf_parser_finds_blocks_layers_and_points(golden, dialect):
    if not (READERS / "node_modules" / "dxf-parser").is_dir():
        absent("npm's dxf-parser (npm install in tests/export/readers)")
    drawing = json.loads(run("node", READERS / "read_dxf.js", golden.folder / f"pattern-{dialect}.dxf"))
    assert sorted(drawing["inserts"]) == sorted(drawing["blocks"]) == sorted(f"{name}_ONE" for name in golden.pieces)
    for name, piece in golden.pieces.items():
        entities = drawing["blocks"][f"{name}_ONE"]
        lines = {e["layer"]: np.array(e["vertices"]) for e in entities if e["type"] == "POLYLINE"}
        assert np.abs(lines["1"] - piece["cut_line"]).max() <= 1e-9
        assert np.abs(lines["14"] - golden.flat[piece["patch"]]).max() <= 1e-9
        points = [e for e in entities if e["type"] == "POINT" and e["layer"] in "23"]
        assert len(points) == len(lines["1"]) + len(lines["14"])
