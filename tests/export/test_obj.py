"""A written OBJ gives back every number to the last bit."""

import numpy as np

from flatnet.export import obj
from flatnet.export.obj import write_obj


def read_obj(path):
    rows = {"v": [], "vt": [], "f": []}
    for line in path.read_text().splitlines():
        kind, *fields = line.split()
        if kind in rows:
            rows[kind].append(fields)
    faces = np.array([[field.split("/") for field in face] for face in rows["f"]], int) - 1
    return np.array(rows["v"], float), np.array(rows["vt"], float), faces


def test_every_number_comes_back_to_the_last_bit(tmp_path):
    random = np.random.default_rng(0)
    vertices = random.normal(size=(50, 3)) * 10.0 ** random.integers(-9, 5, (50, 3))
    flat = random.normal(size=(50, 2)) * 1000.0 / 3.0
    triangles = random.integers(0, 50, (80, 3))
    write_obj(tmp_path / "patch.obj", vertices, triangles, flat)
    v, vt, faces = read_obj(tmp_path / "patch.obj")
    assert np.array_equal(v, vertices) and np.array_equal(vt, flat)
    assert np.array_equal(faces[..., 0], triangles) and np.array_equal(faces[..., 1], triangles)


def test_what_was_written_is_read_back(tmp_path):
    random = np.random.default_rng(1)
    vertices, flat = random.normal(size=(20, 3)) / 3.0, random.normal(size=(20, 2)) * 1e5
    triangles = random.integers(0, 20, (30, 3))
    write_obj(tmp_path / "patch.obj", vertices, triangles, flat)
    for found, given in zip(obj.read_obj(tmp_path / "patch.obj"), (vertices, triangles, flat), strict=True):
        assert np.array_equal(found, given)
