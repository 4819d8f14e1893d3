"""A project drawn on a real body: one leg from the thigh to the calf, in eight panels between rings and lines."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
import trimesh
import yaml

BODY = Path(__file__).parents[3] / "shared" / "data" / "body" / "female_generic.obj"
#: Heights of the rings and the middle of the left leg there, mm; the figure faces -y, its left is +x.
RINGS = {"thigh": (110.0, -60.0, -200.0), "knee": (142.0, -36.0, -400.0), "calf": (165.0, -18.0, -600.0)}
DIRECTIONS = {"front": (0, -1, 0), "outer": (1, 0, 0), "back": (0, 1, 0), "inner": (-1, 0, 0)}


def leg_project(folder: Path) -> Path:
    """Write the body's mesh and a project on it into `folder`; skips the test where the body is not at hand."""
    if not BODY.is_file():
        pytest.skip(f"real input is absent: {BODY}")
    body = trimesh.load_mesh(BODY, process=False)
    joined = trimesh.Trimesh(body.vertices, body.faces, process=False)
    joined.merge_vertices()
    max(joined.split(only_watertight=False), key=lambda part: len(part.vertices)).export(folder / "body.obj")
    nodes = {
        f"{side}_{ring}": {"ray": {"from": list(middle), "direction": list(direction)}}
        for ring, middle in RINGS.items()
        for side, direction in DIRECTIONS.items()
    }
    curves: dict[str, object] = {}
    for ring, middle in RINGS.items():
        names = [f"{side}_{ring}" for side in DIRECTIONS]
        section = {"point": list(middle), "normal": [0, 0, 1]}
        curves[ring] = {"section": section, "points": names}
    for side in DIRECTIONS:
        through = [f"{side}_{ring}" for ring in RINGS]
        curves[side] = {
            "on": "surface", "kind": "fair", "from": through[0], "to": through[-1], "points": through[1:-1]
        }  # fmt: skip
    sides, rings = list(DIRECTIONS), list(RINGS)
    patches = {
        f"{left}_{right}_{upper}": {"around": [left, lower, f"-{right}", f"-{upper}"]}
        for left, right in zip(sides, sides[1:] + sides[:1])
        for upper, lower in pairwise(rings)
    }
    project = {
        "flatnet": 1,
        "name": "leg",
        "edge_length": 15,
        "surface": {"mesh": "body.obj", "units": "dm", "up": "y"},
        "nodes": nodes,
        "curves": curves,
        "patches": patches,
        "openings": {"above": {"around": ["thigh"]}, "below": {"around": ["-calf"]}},
        "nesting": {"seconds": 1},
    }
    (folder / "project.yaml").write_text(yaml.safe_dump(project))
    return folder / "project.yaml"
