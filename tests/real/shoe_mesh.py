"""A project drawn on a real mesh: the upper of a slip-on shoe in four pieces, foot and sole open."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

SHOES = Path(__file__).parents[3] / "shared" / "data" / "shoe" / "shoes02.obj"

#: The left shoe as it stands in the file, in mm with z up: heel at +y, toe at -y, inner side at -x. Every node is
#: where a ray from outside first meets it, so that it lies on the outer face, not on the lining.
PROJECT = """\
flatnet: 1
name: slip_on
units: mm
edge_length: 9
surface: {mesh: shoe.obj, units: dm, up: y}
nodes:
  heel_top: {ray: {from: [200, 200, -745], direction: [0, -1, 0]}}
  inner_back_top: {ray: {from: [0, 10, -757], direction: [1, 0, 0]}}
  inner_top: {ray: {from: [0, -30, -764], direction: [1, 0, 0]}}
  inner_front_top: {ray: {from: [0, -65, -750], direction: [1, 0, 0]}}
  throat: {ray: {from: [200, -94, 0], direction: [0, 0, -1]}}
  outer_front_top: {ray: {from: [400, -65, -750], direction: [-1, 0, 0]}}
  outer_top: {ray: {from: [400, -30, -764], direction: [-1, 0, 0]}}
  outer_back_top: {ray: {from: [400, 10, -757], direction: [-1, 0, 0]}}
  heel: {ray: {from: [200, 200, -815], direction: [0, -1, 0]}}
  inner_back: {ray: {from: [0, 10, -815], direction: [1, 0, 0]}}
  inner: {ray: {from: [0, -75, -815], direction: [1, 0, 0]}}
  inner_ball: {ray: {from: [0, -125, -815], direction: [1, 0, 0]}}
  inner_toe: {ray: {from: [0, -170, -815], direction: [1, 0, 0]}}
  toe: {ray: {from: [192, -400, -808], direction: [0, 1, 0]}}
  outer_toe: {ray: {from: [400, -170, -815], direction: [-1, 0, 0]}}
  outer_ball: {ray: {from: [400, -125, -815], direction: [-1, 0, 0]}}
  outer: {ray: {from: [400, -75, -815], direction: [-1, 0, 0]}}
  outer_back: {ray: {from: [400, 10, -815], direction: [-1, 0, 0]}}
  vamp: {ray: {from: [195, -160, 0], direction: [0, 0, -1]}}
curves:
  topline: {kind: fair, from: heel_top, to: heel_top, points: [
    inner_back_top, inner_top, inner_front_top, throat, outer_front_top, outer_top, outer_back_top]}
  feather: {kind: fair, from: heel, to: heel, points: [
    inner_back, inner, inner_ball, inner_toe, toe, outer_toe, outer_ball, outer, outer_back]}
  back_seam: {kind: fair, from: heel_top, to: heel}
  seam_inner: {kind: fair, from: inner_top, to: inner}
  seam_outer: {kind: fair, from: outer_top, to: outer}
  toe_line: {kind: fair, from: inner_toe, to: outer_toe, points: [vamp]}
patches:
  quarter_inner: {around: [feather, -seam_inner, -topline, back_seam]}
  quarter_outer: {around: [feather, -back_seam, -topline, seam_outer]}
  vamp: {around: [toe_line, feather, -seam_outer, -topline, seam_inner, feather]}
  toe: {around: [feather, -toe_line]}
openings:
  foot: {around: [topline]}
  sole: {around: [-feather]}
materials:
  leather: {width: 600, gap: 3, allowance: 5}
nesting: {seconds: 1}
"""


def shoe_project(folder: Path) -> Path:
    """Write the left shoe's mesh and the project on it into `folder`; the path of the project file.

    Skips the test where the shoes' mesh is not at hand.
    """
    if not SHOES.is_file():
        pytest.skip(f"real input is absent: {SHOES}")
    shoes = trimesh.load_mesh(SHOES, process=False)
    joined = trimesh.Trimesh(shoes.vertices, shoes.faces, process=False)
    joined.merge_vertices()
    # Two shoes and two socks: of the larger parts, the one at +x.
    parts = sorted(joined.split(only_watertight=False), key=lambda part: -len(part.vertices))[:2]
    max(parts, key=lambda part: part.bounds[0, 0]).export(folder / "shoe.obj")
    file = folder / "project.yaml"
    file.write_text(PROJECT, encoding="utf-8")
    return file
