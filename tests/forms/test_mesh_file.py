"""A user's mesh becomes a surface in mm, z up, smooth; or a message that says what is wrong with it."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from flatnet.forms.mesh_file import MeshFileError, read_mesh
from flatnet.project.model import MeshSurface
from flatnet.project.problems import Mark


def read(path: Path, mm_per_unit: float = 1.0, up: str = "z", outer: str = "outside"):
    return read_mesh(MeshSurface(path, mm_per_unit, up, outer, Mark(1, 1)))


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply"])
def test_formats_give_the_same_smooth_surface(tmp_path, suffix):
    """STL repeats its vertices for every facet; read as they stand, its normals would be the facets'."""
    ball = trimesh.creation.icosphere(3, 10.0)
    path = tmp_path / f"ball.{suffix}"
    ball.export(path)
    surface = read(path)
    assert len(surface.mesh.vertices) == len(ball.vertices)
    points = np.random.default_rng(0).normal(size=(200, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    _, normals = surface.nearest(10.0 * points)
    assert np.einsum("ij,ij->i", normals, points).min() > np.cos(np.radians(1.0))  # facets: 5 degrees off


def test_vertices_that_a_texture_seam_parts_are_joined(tmp_path):
    path = written(
        tmp_path / "fold.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt .5 .5\n"
        "f 1/1 2/2 3/3\nf 1/4 3/5 4/1\n",
    )
    assert len(read(path).mesh.vertices) == 4


def test_polygons_are_cut_into_triangles(tmp_path):
    path = written(tmp_path / "quad.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4\n")
    surface = read(path)
    assert len(surface.mesh.faces) == 2
    assert surface.mesh.area == pytest.approx(2.0)


def test_units(tmp_path):
    path = tmp_path / "box.obj"
    trimesh.creation.box([1.0, 2.0, 3.0]).export(path)
    assert read(path, mm_per_unit=25.4).mesh.extents == pytest.approx([25.4, 50.8, 76.2])


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_the_up_axis_becomes_z_by_a_turn(tmp_path, up):
    axis = "xyz".index(up)
    tip = np.zeros(3)
    tip[axis] = 5.0
    base = np.roll(np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 1.0], [0.0, -1.0, -1.0]]), axis, axis=1)
    cone = trimesh.Trimesh(np.vstack([tip, base]), [[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]])
    path = tmp_path / "cone.ply"
    cone.export(path)
    mesh = read(path, up=up).mesh
    highest = mesh.vertices[np.argmax(mesh.vertices[:, 2])]
    assert highest == pytest.approx([0.0, 0.0, 5.0])
    assert mesh.volume == pytest.approx(cone.volume)  # its sign would change under a reflection


def test_y_up_looks_along_minus_y(tmp_path):
    path = written(tmp_path / "front.obj", "v 0 0 7\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert read(path, up="y").mesh.vertices[0] == pytest.approx([0.0, -7.0, 0.0])


def test_the_inside_of_a_mesh(tmp_path):
    path = tmp_path / "ball.stl"
    trimesh.creation.icosphere(2, 10.0).export(path)
    point = np.array([[0.0, 0.0, 12.0]])
    assert read(path).nearest(point)[1][0] @ [0, 0, 1] > 0.99
    assert read(path, outer="inside").nearest(point)[1][0] @ [0, 0, 1] < -0.99


@pytest.mark.parametrize("seed", range(8))  # the repair starts from one face: now right, now wrong
def test_faces_that_turn_against_the_others_are_turned_round(tmp_path, seed):
    ball = trimesh.creation.icosphere(1, 10.0)
    faces = ball.faces.copy()
    turned = np.random.default_rng(seed).choice(len(faces), len(faces) // 3, replace=False)
    faces[turned] = faces[turned][:, ::-1]
    path = tmp_path / "ball.ply"
    trimesh.Trimesh(ball.vertices, faces, process=False).export(path)
    mesh = read(path).mesh
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(ball.volume)


def test_a_one_sided_mesh_is_refused(tmp_path):
    n = 24
    angle = 2.0 * np.pi * np.arange(n) / n
    rims = [
        np.column_stack(
            [
                (10 + s * np.cos(angle / 2)) * np.cos(angle),
                (10 + s * np.cos(angle / 2)) * np.sin(angle),
                s * np.sin(angle / 2),
            ]
        )
        for s in (-2.0, 2.0)
    ]
    faces = []
    for i in range(n):
        a, b = i, n + i
        c, d = (i + 1, n + i + 1) if i + 1 < n else (n, 0)  # the band is joined with half a turn
        faces += [[a, c, d], [a, d, b]]
    path = tmp_path / "moebius.ply"
    trimesh.Trimesh(np.vstack(rims), faces, process=False).export(path)
    with pytest.raises(MeshFileError, match="no common outer side"):
        read(path)


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("empty.obj", "", "no faces|could not be read"),
        ("empty.stl", "", "no faces|could not be read"),
        ("empty.ply", "", "no faces|could not be read"),
        ("noise.ply", "this is no mesh\n", "could not be read"),
        ("cloud.obj", TRIANGLE, "no faces"),
        ("lines.obj", TRIANGLE + "l 1 2 3\n", "no faces"),
        ("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "no finite numbers, the first is vertex 2"),
        ("thin.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "have no area"),
        ("point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "have no area"),
        ("beyond.obj", TRIANGLE + "f 1 2 9\n", "could not be read|beyond"),
        ("last.step", "", "a mesh file ends in"),
    ],
)
def test_files_that_are_no_surface(tmp_path, name, text, message):
    with pytest.raises(MeshFileError, match=message):
        read(written(tmp_path / name, text))


def test_a_missing_file(tmp_path):
    with pytest.raises(MeshFileError, match=r"there is no mesh file .*last\.stl"):
        read(tmp_path / "last.stl")


def test_triangles_without_area_are_dropped(tmp_path):
    path = written(tmp_path / "some.obj", TRIANGLE + "v 1 1 0\nf 1 2 3\nf 2 4 3\nf 1 1 2\nf 2 2 2\n")
    surface = read(path)
    assert len(surface.mesh.faces) == 2
    _, normals = surface.nearest(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 2.0]]))
    assert np.allclose(normals, [0.0, 0.0, 1.0])
