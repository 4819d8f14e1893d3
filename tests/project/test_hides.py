"""Hides in a project file: as points, as drawings, with defects and zones."""

from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely
from test_loader import load, problems_of

SQUARE = """\
flatnet: 1
name: square
units: cm
edge_length: 2
curves:
  rim: {closed: true, points: [[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]], normals: [0, 0, 1]}
patches:
  top: {around: [rim], grain: [1, 0, 0], zone: A, match: true}
materials:
  leather:
    gap: 0.1
    rotations: free
    hides: HIDES
"""
POINTS = (
    "{outline: [[5, 2], [35, 2], [30, 22], [5, 20]], defects: [[[10, 5], [12, 5], [12, 8]]], "
    "zones: {A: [[5, 2], [25, 2], [25, 20]]}}"
)


def hides(folder: Path, text: str):
    return load(folder, SQUARE.replace("HIDES", text)).materials["leather"].hides


def test_points_are_in_the_unit_of_the_file_and_the_box_starts_at_the_origin(tmp_path: Path) -> None:
    (hide,) = hides(tmp_path, POINTS)
    assert hide.outline == ((0.0, 0.0), (300.0, 0.0), (250.0, 200.0), (0.0, 180.0))
    assert hide.size == (300.0, 200.0)
    assert hide.defects == (((50.0, 30.0), (70.0, 30.0), (70.0, 60.0)),)
    assert hide.region.area == pytest.approx(shapely.Polygon(hide.outline).area - 300.0, rel=1e-12)
    assert hide.zone("A").area == pytest.approx(0.5 * 200.0 * 180.0 - 300.0, rel=1e-12)
    assert hide.zone("B").is_empty


def test_the_material_is_as_large_as_its_largest_hide_and_pieces_ask_for_it(tmp_path: Path) -> None:
    project = load(tmp_path, SQUARE.replace("HIDES", f"[{POINTS}, {{outline: [[0, 0], [40, 0], [40, 5]]}}]"))
    material = project.materials["leather"]
    assert (material.length, material.width, material.count) == (400.0, 200.0, 2)
    assert (project.patches["top"].zone, project.patches["top"].match) == ("A", True)


def test_a_drawing_has_outline_defects_and_zones(tmp_path: Path) -> None:
    document = ezdxf.new()
    space = document.modelspace()
    for layer, points in (
        ("scar", [[10, 10], [14, 10], [14, 13]]),
        ("hide", [[0, 0], [100, 0], [100, 60], [0, 60]]),
        ("Zone_A", [[0, 0], [50, 0], [50, 60], [0, 60]]),
    ):
        space.add_lwpolyline(points, close=True, dxfattribs={"layer": layer})
    space.add_line((0, 0), (20, 20))  # no closed curve
    document.saveas(tmp_path / "hide.dxf")
    (hide,) = hides(tmp_path, "{outline: hide.dxf}")
    assert hide.area == pytest.approx(6000.0 * 100.0)  # cm, as the file's own
    assert hide.region.area == pytest.approx((6000.0 - 6.0) * 100.0)
    assert hide.zone("A").area == pytest.approx((3000.0 - 6.0) * 100.0)
    (hide,) = hides(tmp_path, "{outline: hide.dxf, units: mm}")
    assert hide.size == (100.0, 60.0)


def test_an_svg_lies_as_it_is_seen(tmp_path: Path) -> None:
    (tmp_path / "hide.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="60mm" viewBox="0 0 100 60">'
        '<path d="M 0 0 H 100 V 60 Z"/><path id="zone_A" d="M 50 10 h 20 v 10 z"/></svg>'
    )
    (hide,) = hides(tmp_path, "{outline: hide.svg, units: mm}")
    # The corner at the top left of the page is at the top left of the hide: y up.
    assert np.allclose(sorted(hide.outline), [(0.0, 60.0), (100.0, 0.0), (100.0, 60.0)])
    assert np.allclose(hide.zone("A").bounds, (50.0, 40.0, 70.0, 50.0))


def test_what_is_drawn_with_curves_and_corners_is_whole_and_true(tmp_path: Path) -> None:
    """Half disks: drawn as one path of two parts, neither of them closed, their bows within 0.1 mm."""
    (tmp_path / "hide.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="2000mm" height="1000mm" viewBox="0 0 2000 1000">'
        '<path d="M 0 0 A 1000 1000 0 0 0 2000 0 L 1000 -9 Z"/>'
        '<path id="zone_A" d="M 200 100 h 900 v 300 h -900 z"/>'
        '<path id="scar" d="M 500 200 a 50 50 0 0 0 100 0 z"/></svg>'
    )
    (hide,) = hides(tmp_path, "{outline: hide.svg, units: mm}")
    assert hide.size == pytest.approx((2000.0, 1009.0))
    (scar,) = hide.defects
    assert shapely.Polygon(scar).area == pytest.approx(0.5 * np.pi * 50.0**2, rel=0.005)
    bow = np.array([point for point in hide.outline if point[1] < 999.0])
    middles = 0.5 * (bow[1:] + bow[:-1])
    assert 999.9 < np.linalg.norm(middles - [1000.0, 1000.0], axis=1).min() < 1000.0


def test_a_drawing_without_a_closed_curve_is_told(tmp_path: Path) -> None:
    (tmp_path / "line.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M 0 0 H 9"/></svg>')
    (problem, *_) = problems_of(tmp_path, SQUARE.replace("HIDES", "{outline: line.svg}"))
    assert "the drawing has no closed curve" in problem.message
    assert (problem.mark.line, problem.mark.column) == (13, 22)


def test_width_and_hides_exclude_each_other(tmp_path: Path) -> None:
    text = SQUARE.replace("HIDES", POINTS).replace("gap: 0.1", "width: 9")
    (problem,) = problems_of(tmp_path, text)
    assert "'hides' and 'width' exclude each other" in problem.message


def test_a_zone_on_a_material_that_is_not_there_is_one_problem(tmp_path: Path) -> None:
    text = SQUARE.replace("HIDES", POINTS).replace("zone: A", "zone: A, material: felt")
    (problem,) = problems_of(tmp_path, text)
    assert "felt" in problem.message
