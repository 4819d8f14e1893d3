"""Pieces that are cut on the fold: the whole is the half and its mirror image, exactly, and the half has the fold."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
import yaml
from pieces import cloth, fitted
from svgelements import SVG, Path
from test_allowance import check_distances
from written import read_report

from flatnet.cli import main
from flatnet.failure import PatchFailure
from flatnet.network.patch import Stretch
from flatnet.pattern import make_piece
from flatnet.pattern.allowance import GRID
from flatnet.pattern.notches import SeamNotch
from flatnet.pattern.on_fold import half_on_fold
from flatnet.pattern.seams import Seam
from flatnet.project.patch_specs import MarkSpec
from flatnet.project.problems import Mark
from flatnet.project.seam_specs import DartSpec, Ends, NotchSpec, SeamSpec

UP = [0, 0, 1]


def half(seed, bend=0.0):
    """A piece above the x axis, with its fold from (0, 0) to (200, 0), turned somewhere: 6 and 4 x 12 edges."""
    random = np.random.default_rng(seed)
    x = np.linspace(0.0, 200.0, 7)
    fold = np.column_stack([x, bend * np.sin(np.pi * x / 200.0)])
    angle = np.linspace(0.0, np.pi, 49)
    wave = 80.0 + 12.0 * np.sin(4 * angle + random.uniform(0, 6)) + 6.0 * np.sin(7 * angle + random.uniform(0, 6))
    rim = np.column_stack([100.0 + 100.0 * np.cos(angle), wave * np.sin(angle) ** random.uniform(0.5, 0.9)])
    turn = random.uniform(0, 2 * np.pi)
    frame = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    outline = np.concatenate([fold[:-1], rim[:-1]]) @ frame
    shift = int(random.integers(len(outline)))
    starts = [0, 6, 18, 30, 42]
    stretches = tuple(
        Stretch(f"s{i}", (first - shift) % 54, 6 if i == 0 else 12, bool(i % 2)) for i, first in enumerate(starts)
    )
    whole = [stretch for stretch in stretches if stretch.first + stretch.count <= 54]
    if len(whole) < len(stretches):  # a seam does not pass the boundary's first vertex
        return half(seed + 1000, bend)
    made = fitted(np.roll(outline, -shift, axis=0), stretches=tuple(sorted(whole, key=lambda s: s.first)))
    return replace(made, patch=replace(made.patch, fold="s0"))


def seams_of(widths, **specs):
    return {
        f"s{i}": Seam(f"s{i}", i + 1, f"s{i}", replace(SeamSpec(w, w), **specs.get(f"s{i}", {})), ("piece",), 1.0,
                      (SeamNotch(3, 0.25, 1.0), SeamNotch(8, 0.5, 1.0)) if i else ())
        for i, w in enumerate(widths)
    }  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_the_whole_is_the_half_and_its_mirror_image(seed):
    patch = half(seed)
    widths = [5.0, 10.0, 4.0, 0.0, 7.0]
    hem = {"ends": Ends("mirrored"), "notches": NotchSpec(depth=2.0)}
    inside = patch.outline.mean(axis=0)
    mark = MarkSpec("button", "drill", (np.array([*inside, 0.0]),), False, False, None, Mark(1, 1))
    made = make_piece(patch, cloth(), seams_of(widths, s1=hem, s4={"notches": NotchSpec(depth=2.0)}), marks=[mark])
    across = made.fold.reflect

    def is_symmetric(points):
        images = across(np.array(points))
        return all(np.linalg.norm(points - image, axis=1).min() <= 1e-9 for image in images)

    assert len(made.sew_line) == 2 * (len(patch.outline) - 6)
    assert is_symmetric(made.sew_line)
    assert shapely.Polygon(made.sew_line).area == pytest.approx(2.0 * shapely.Polygon(patch.outline).area, rel=1e-12)
    image = shapely.transform(made.region, across)
    assert shapely.symmetric_difference(made.region, image, grid_size=GRID).area < 1e-3
    assert len(made.notches) == 8 and is_symmetric([notch.foot for notch in made.notches])
    assert is_symmetric(np.concatenate([m.points for m in made.marks if m.kind == "drill"]))
    assert len([m for m in made.marks if m.kind == "drill"]) == 2
    # Its allowances are true all round, also across the fold.
    edge_widths = np.zeros(len(made.sew_line))
    for run in made.seams:
        count = len(made.sew_line)
        edges = [min(a, b) if abs(a - b) == 1 else count - 1 for a, b in zip(run.vertices, run.vertices[1:])]
        edge_widths[edges] = widths[run.seam.number - 1]
    plain = make_piece(patch, cloth(), seams_of(widths))
    check_distances(plain.sew_line, edge_widths, plain.cut_line)

    part = half_on_fold(made, made.fold)
    assert part.area == pytest.approx(0.5 * made.area, rel=1e-9)
    assert made.fold.heights(part.cut_line).min() >= -1e-6
    both = shapely.union(part.region, shapely.transform(part.region, across), grid_size=GRID)
    assert shapely.symmetric_difference(both, made.region, grid_size=GRID).area < 1e-3
    assert len(part.notches) == 4 and len(part.seams) == 4
    assert "cut 1 on the fold" in part.label.lines
    assert made.region.covers(shapely.LineString(made.fold.line)) and "cut 1" in made.label.lines


def test_a_curve_that_bends_in_the_flat_piece_is_no_fold():
    with pytest.raises(PatchFailure) as caught:
        make_piece(half(0, bend=1.5), cloth(), seams_of([0.0] * 5))
    assert (caught.value.finding.code, caught.value.finding.amount) == ("no_fold", pytest.approx(1.5))
    make_piece(half(0, bend=0.9), cloth(), seams_of([0.0] * 5))


def test_a_dart_is_on_both_halves_and_folded_to_mirrored_sides():
    outline = [[0, 0], [100, 0], [100, 40], [60, 50], [100, 60], [100, 100], [0, 100]]
    names = ["fold", "hem", "dart", "dart", "hem2", "top", "side"]
    stretches = tuple(Stretch(name, i, 1, i == 3) for i, name in enumerate(names))
    made = fitted(outline, stretches=stretches, slit_tips=(3,))
    made = replace(made, patch=replace(made.patch, fold="fold"))
    seams = {n: Seam(n, i, n, SeamSpec(5.0, 5.0), ("piece",), 1.0) for i, n in enumerate(dict.fromkeys(names), 1)}
    seams["dart"] = replace(seams["dart"], spec=SeamSpec(dart=DartSpec("left")))
    piece = make_piece(made, cloth(), seams)
    assert piece.region.symmetric_difference(shapely.transform(piece.region, lambda p: p * [1, -1])).area < 1e-6
    arrows = [mark.points for mark in piece.marks if mark.name == "dart direction"]
    np.testing.assert_allclose(arrows[0][:2] * [1, -1], arrows[1][:2], atol=1e-9)
    assert len(piece.marks) == 7  # two darts of three, and the fold


def test_layouts_have_the_whole_piece_and_a_file_the_half(tmp_path, capsys):
    nodes = {"a": [0, 0, 0], "b": [100, 0, 0], "c": [100, 60, 0], "d": [0, 40, 0]}
    curves = {p + q: {"from": p, "to": q, "normals": UP} for p, q in ("ab", "bc", "cd", "da")}
    project = {
        "flatnet": 1, "name": "yoke", "edge_length": 20, "nodes": nodes, "curves": curves,
        "patches": {"yoke": {"around": ["ab", "bc", "cd", "da"], "fold": "ab"}},
        "rest": "openings", "materials": {"cloth": {"width": 500, "allowance": 10}}, "nesting": {"seconds": 1},
    }  # fmt: skip
    (tmp_path / "yoke.yaml").write_text(yaml.safe_dump(project))
    assert main(["build", str(tmp_path / "yoke.yaml"), "-o", str(tmp_path / "out")]) == 0

    def height(file, kind):
        (path,) = [e for e in SVG.parse(str(file), ppi=25.4).elements()
                   if isinstance(e, Path) and e.values.get("class") == kind]
        return np.ptp(np.array([[p.x, p.y] for p in path.as_points()])[:, 1])

    pieces = tmp_path / "out" / "pieces"
    assert height(pieces / "yoke.svg", "sew") == pytest.approx(120.0, abs=0.01)
    assert height(pieces / "yoke_on_fold.svg", "sew") == pytest.approx(60.0, abs=0.01)
    assert "grain" in (pieces / "yoke.svg").read_text()  # along the fold
    assert "pieces/yoke_on_fold.svg" in read_report(tmp_path / "out")["files"]
    assert height(tmp_path / "out" / "layout-cloth.svg", "sew") == pytest.approx(120.0, abs=0.01)
    project["patches"]["yoke"]["fold"] = "bd"
    (tmp_path / "yoke.yaml").write_text(yaml.safe_dump(project))
    assert main(["check", str(tmp_path / "yoke.yaml")]) == 2
    assert "patch 'yoke': fold: 'bd' is not around the patch" in capsys.readouterr().err
