"""A patch cut from several materials: each piece on its own sheet, in its own file, with its own allowance."""

import numpy as np
import pytest
import shapely
import yaml
from svgelements import SVG, Path
from written import READER_SCALE, read_report

from flatnet.cli import main

UP = [0, 0, 1]


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("also")
    corners = {"a": [0, 0, 0], "b": [100, 0, 0], "c": [100, 60, 0], "d": [0, 60, 0]}
    names = ["ab", "bc", "cd", "da"]
    project = {
        "flatnet": 1,
        "name": "bag",
        "edge_length": 25,
        "nodes": corners,
        "curves": {name: {"from": name[0], "to": name[1], "normals": UP} for name in names},
        "patches": {
            "side": {
                "around": names,
                "material": "canvas",
                "cut": 1,
                "mirrored": 1,
                "also": {"lining": {"allowance": 4}, "canvas-2": {"cut": 3, "mirrored": 0}},
            }
        },
        "rest": "openings",
        "materials": {
            "canvas": {"width": 300, "allowance": 10},
            "lining": {"width": 300},
            "canvas-2": {"width": 300, "allowance": 7},
        },
        "nesting": {"seconds": 1},
    }
    project["curves"]["ab"]["allowance"] = 20
    (folder / "bag.yaml").write_text(yaml.safe_dump(project))
    assert main(["build", str(folder / "bag.yaml"), "-o", str(folder / "out")]) == 0
    return folder / "out"


def test_every_material_has_its_sheet_with_its_copies(out):
    report = read_report(out)
    laid = {layout["material"]: [piece["mirrored"] for piece in layout["pieces"]] for layout in report["layouts"]}
    assert laid == {"canvas": [False, True], "lining": [False, True], "canvas-2": [False] * 3}
    assert report["status"] == "ok"
    for layout in report["layouts"]:
        assert "INCOMPLETE" not in (out / layout["file"]).read_text()


@pytest.mark.parametrize(
    "file, size",
    [("side", (120, 90)), ("side_lining", (108, 68)), ("side_canvas-2", (114, 87))],  # 100 x 60 and allowances
)
def test_each_piece_has_its_own_allowances(out, file, size):
    assert f"pieces/{file}.svg" in read_report(out)["files"]
    paths = SVG.parse(str(out / "pieces" / f"{file}.svg"), ppi=25.4).elements()
    (cut,) = [path for path in paths if isinstance(path, Path) and path.values.get("class") == "cut"]
    cut = np.array([[s.end.x, s.end.y] for s in cut * cut.transform][:-1]) / READER_SCALE
    sizes = sorted(np.ptp(shapely.get_coordinates(shapely.Polygon(cut)), axis=0))
    assert sizes == pytest.approx(sorted(size), abs=0.002)
