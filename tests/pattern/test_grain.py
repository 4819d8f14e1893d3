"""Where the grain of a piece runs: along a curve, between nodes, in a direction; how its arrow is drawn."""

import numpy as np
import pytest
import yaml
from pieces import SQUARE, cloth, piece

from flatnet.fitting.fit import fit_patch
from flatnet.network.assembly import make_network
from flatnet.parameters import FairParameters
from flatnet.pattern.labels import arrow_head
from flatnet.project import ProjectError, load_project

PLACES = {"a": [0, 0, 0], "b": [70, 12, 0], "c": [150, 0, 0], "d": [160, 90, 0], "e": [75, 80, 0], "f": [0, 95, 0]}
UP = [0, 0, 1]


def network(folder, **grains):
    """Two level patches side by side; the curve `top` runs over both, from right to left; `far` lies elsewhere."""
    curves = {
        "low": {"from": "a", "points": ["b"], "to": "c"},
        "top": {"from": "d", "points": ["e"], "to": "f"},
        "left_end": {"from": "f", "to": "a"},
        "right_end": {"from": "c", "to": "d"},
        "middle": {"from": "b", "points": [[80, 45, 0]], "to": "e"},
        "far": {"from": "g", "points": [[310, 40, 0]], "to": "h"},
        "back": {"from": "h", "to": "g", "points": [[300, -40, 0]]},
    }
    project = {
        "flatnet": 1,
        "name": "level",
        "edge_length": 20,
        "nodes": {**PLACES, "g": [300, 0, 0], "h": [330, 30, 0]},
        "curves": {name: {**curve, "normals": UP} for name, curve in curves.items()},
        "patches": {
            "left": {"around": ["low:a..b", "middle", "top:e..f", "left_end"]},
            "right": {"around": ["low:b..c", "right_end", "top:d..e", "-middle"]},
        },
        "rest": "openings",
    }
    for patch, grain in grains.items():
        project["patches"][patch]["grain"] = grain
    (folder / "level.yaml").write_text(yaml.safe_dump(project))
    return make_network(load_project(folder / "level.yaml"), None)


def fitted(folder, patch, **grains):
    (found,) = [each for each in network(folder, **grains).patches if each.name == patch]
    return fit_patch(found, FairParameters(), {})


def direction(made, first, last):
    """Angle of the line between two nodes on the flat piece, degrees from +x."""
    rim = made.patch.boundary.vertices
    tail, head = (int(np.argmin(np.linalg.norm(rim - PLACES[node], axis=1))) for node in (first, last))
    x, y = made.flat[head] - made.flat[tail]
    return float(np.degrees(np.arctan2(y, x)))


@pytest.mark.parametrize(
    "patch, grain, first, last",
    [
        ("left", {"along": "low"}, "a", "b"),
        ("right", {"along": "low"}, "b", "c"),
        ("left", {"along": "top"}, "e", "f"),
        ("left", {"along": "-top"}, "f", "e"),
        ("left", {"along": "middle"}, "b", "e"),
        ("right", {"along": "middle"}, "b", "e"),  # on its right side too
        ("right", {"along": "-middle"}, "e", "b"),
        ("left", {"from": "a", "to": "e"}, "a", "e"),
        ("right", {"from": "d", "to": "b"}, "d", "b"),
    ],
)
def test_a_line_of_the_boundary_lies_along_the_roll(tmp_path, patch, grain, first, last):
    made = fitted(tmp_path, patch, **{patch: grain})
    assert made.has_grain and not made.warnings
    assert direction(made, first, last) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("grain", [{"along": "far"}, {"from": "g", "to": "h"}, [1, 1, 0]])
def test_a_line_elsewhere_is_a_direction_in_space(tmp_path, grain):
    made = fitted(tmp_path, "left", left=grain)
    slope = np.degrees(np.arctan2(95 - 0, 0))
    assert direction(made, "a", "f") == pytest.approx(slope - 45.0, abs=1e-6)


def test_a_level_patch_of_which_nothing_is_said_is_laid_by_its_extent_with_an_arrow(tmp_path):
    made = fitted(tmp_path, "left")
    assert made.has_grain and not made.warnings
    outline = made.outline - made.outline.mean(axis=0)
    assert np.ptp(outline[:, 0]) > np.ptp(outline[:, 1])


def test_a_closed_curve_has_no_direction(tmp_path):
    closed = {"flatnet": 1, "name": "x", "edge_length": 20, "rest": "openings"}
    closed["curves"] = {"rim": {"closed": True, "points": [[0, 0, 0], [90, 0, 0], [50, 80, 0]], "normals": UP}}
    closed["patches"] = {"p": {"around": ["rim"], "grain": {"along": "rim"}}}
    (tmp_path / "x.yaml").write_text(yaml.safe_dump(closed))
    with pytest.raises(ProjectError, match="'rim' ends where it starts; name two nodes"):
        make_network(load_project(tmp_path / "x.yaml"), None)


@pytest.mark.parametrize("rotations, one_way", [((0.0, 180.0), False), ((0.0,), True), (None, False), ((90.0,), True)])
def test_the_arrow_has_one_head_where_pieces_may_not_be_turned(rotations, one_way):
    assert piece(SQUARE, cloth(rotations=rotations)).one_way == one_way


def test_on_leather_there_is_an_arrow_only_where_it_is_asked_for():
    assert piece(SQUARE, cloth(rotations=None)).grain is not None
    assert piece(SQUARE, cloth(rotations=None), said=False).grain is None
    assert piece(SQUARE, cloth(), said=False).grain is not None


def test_heads_point_along_their_line():
    line = np.array([[0.0, 0.0], [100.0, 0.0]])
    np.testing.assert_allclose(arrow_head(line), [[94, 2.4], [100, 0], [94, -2.4]])
    np.testing.assert_allclose(arrow_head(line[::-1]), [[6, -2.4], [0, 0], [6, 2.4]])
