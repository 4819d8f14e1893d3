"""What holds of any two pieces and any two copies, over seeds: notches in pairs, mirrored copies exact."""

import numpy as np
import pytest
import yaml
from pieces import blob, cloth, fitted, piece

from flatnet.build import check
from flatnet.geometry.polygon import arclengths
from flatnet.nesting.layout import Placement
from flatnet.pattern import make_piece
from flatnet.pattern.seams import plan_seams

UP = [0, 0, 1]


def halves(seed):
    """A square in two halves along a random curve with random notches."""
    random = np.random.default_rng(seed)
    y = np.linspace(0.0, 200.0, 7)
    wave = np.column_stack([100.0 + random.uniform(-30, 30, 7), y, 0 * y])
    corners = {"a": [0, 0, 0], "c": [200, 0, 0], "d": [200, 200, 0], "f": [0, 200, 0], "b": wave[0], "e": wave[-1]}
    curves = {p + q: {"from": p, "to": q, "normals": UP} for p, q in ("ab", "bc", "cd", "de", "ef", "fa")}
    notches = {"every": float(random.uniform(20, 60)), "at": random.uniform(5, 190, 2).tolist()}
    curves["wave"] = {
        "kind": "spline", "from": "b", "to": "e", "points": wave[1:-1].tolist(), "normals": UP, "notches": notches,
        "allowance": {"left": 6, "right": 11},
    }  # fmt: skip
    nodes = {name: [float(x) for x in place] for name, place in corners.items()}
    patches = {"left": {"around": ["ab", "wave", "ef", "fa"]}, "right": {"around": ["bc", "cd", "de", "-wave"]}}
    materials = {"cloth": {"width": 500, "allowance": 8}}
    return {
        "flatnet": 1, "name": "halves", "edge_length": 9, "nodes": nodes, "curves": curves, "patches": patches,
        "rest": "openings", "materials": materials,
    }  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_both_notches_of_a_pair_lie_at_the_same_arclength(seed, tmp_path):
    (tmp_path / "halves.yaml").write_text(yaml.safe_dump(halves(seed)))
    project, network = check(tmp_path / "halves.yaml")
    seams = plan_seams(project, network)
    random = np.random.default_rng(seed)
    found = []
    for patch in network.patches:
        turn = random.uniform(0, 2 * np.pi)  # each piece lies in its own way
        frame = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        flat = patch.boundary.vertices[:, :2] @ frame
        made = make_piece(fitted(flat, name=patch.name, stretches=patch.boundary.stretches), cloth(), seams)
        (run,) = [run for run in made.seams if run.seam.name == "wave"]
        line = made.sew_line[run.vertices]
        starts, steps, along = line[:-1], np.diff(line, axis=0), arclengths(line)
        places = []
        for notch in made.notches:
            part = np.clip(np.sum((notch.position - starts) * steps, axis=1) / np.sum(steps**2, axis=1), 0.0, 1.0)
            gaps = np.linalg.norm(starts + part[:, None] * steps - notch.position, axis=1)
            edge = int(np.argmin(gaps))
            assert gaps[edge] < 1e-9
            places.append(along[edge] + part[edge] * (along[edge + 1] - along[edge]))
        found.append(sorted(zip(places, [notch.marks for notch in made.notches])))
    assert len(found[0]) == len(found[1]) >= 4
    for (place, marks), (other, others) in zip(*found):
        assert (place, marks) == (pytest.approx(other, abs=1e-6), others)


@pytest.mark.parametrize("seed", range(4))
def test_a_mirrored_copy_is_the_mirror_image_of_a_plain_one(seed):
    made = piece(blob(seed), cloth(allowance=8.0))
    angle = float(np.random.default_rng(seed).uniform(-360, 360))
    mirrored, plain = Placement(made, 2, True, angle, 3.0, 4.0), Placement(made, 1, False, -angle, 3.0, -4.0)
    for line in (made.cut_line, made.sew_line, made.grain):
        assert np.abs(mirrored.place(line) - plain.place(line) * [1.0, -1.0]).max() <= 1e-12
