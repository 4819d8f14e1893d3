"""`min_angle`: the flat piece has at least that angle at the corner; elsewhere nothing is asked."""

import numpy as np
import pytest
import yaml
from written import read_obj

from flatnet.cli import main


def cushion(**patch):
    up = [0.0, 0.0, 1.0]
    nodes = {"a": [0, 0, 0], "b": [200, 0, 0], "c": [200, 200, 0], "d": [0, 200, 0]}
    names = list(nodes)
    # Straight sides would leave no room: a planar convex outline has the least angle sum there is (Lemma 2).
    middles = [[100, 0, 40], [200, 100, -20], [100, 200, 40], [0, 100, -20]]
    curves = {
        p + q: {"kind": "spline", "from": p, "to": q, "points": [middle], "normals": up}
        for p, q, middle in zip(names, names[1:] + names[:1], middles, strict=True)
    }
    return {
        "flatnet": 1, "name": "cushion", "edge_length": 20, "nodes": nodes, "curves": curves,
        "patches": {"top": {"around": list(curves), **patch}}, "rest": "openings",
    }  # fmt: skip


def flat_corner(out, corner):
    vertices, flat, triangles = read_obj(out / "patches" / "top.obj")
    at = int(np.argmin(np.linalg.norm(vertices - corner, axis=1)))
    total = 0.0
    for triangle in triangles[(triangles == at).any(axis=1)]:
        p, q, r = np.roll(triangle, -int(np.flatnonzero(triangle == at)[0]))
        u, v = flat[q] - flat[p], flat[r] - flat[p]
        total += np.arctan2(u[0] * v[1] - u[1] * v[0], u @ v)
    return np.degrees(total)


def test_the_flat_corner_has_the_angle_that_is_asked_for(tmp_path):
    free = built_corner(tmp_path / "free", {})
    least = round(free + 6.0, 1)
    held = built_corner(tmp_path / "held", {"min_angle": {"b": least}})
    assert least - 1e-6 <= held <= least + 1.0  # as far as is asked, and hardly farther
    assert built_corner(tmp_path / "met", {"min_angle": {"b": round(free - 6.0, 1)}}) == pytest.approx(free, abs=1.0)


def built_corner(folder, patch):
    folder.mkdir()
    (folder / "project.yaml").write_text(yaml.safe_dump(cushion(**patch)))
    assert main(["build", str(folder / "project.yaml"), "-o", str(folder / "out")]) == 0
    return float(flat_corner(folder / "out", [200, 0, 0]))
