"""Faces of networks: polyhedra, a torus, the plane; and what `around` may say of them."""

import numpy as np
import pytest
import yaml
from drawn import SQUARE_AROUND, Sphere, Torus, excess, flat, line, network_of, square
from scipy.spatial import Delaunay

from flatnet.project import ProjectError


def polyhedron(vertices, faces, crease=False):
    """Sections for a convex polyhedron round the origin, faces anticlockwise seen from outside.

    The normal of an edge points away from the origin, or on creases each face keeps its own.
    """
    vertices = np.array(vertices, float)
    left_of = {(f[k - 1], f[k]): f for f in faces for k in range(len(f))}
    curves, patches = {}, {}
    for a, b in left_of:
        if a < b:
            left, right = (vertices[list(left_of[e])].mean(axis=0).tolist() for e in ((a, b), (b, a)))
            mean = (vertices[a] + vertices[b]).tolist()
            normals = {"left": left, "right": right} if crease else mean
            curves[f"e{a}{b}"] = line(f"n{a}", f"n{b}", normals=normals)
    for face in faces:
        around = [f"e{a}{b}" if a < b else f"-e{b}{a}" for a, b in zip(face, face[1:] + face[:1])]
        patches["f" + "".join(map(str, face))] = {"around": around}
    nodes = {f"n{i}": v.tolist() for i, v in enumerate(vertices)}
    return {"nodes": nodes, "curves": curves, "patches": patches}


TETRAHEDRON = polyhedron(
    20 * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]),
    [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
)
CUBE_VERTICES = 20 * np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
CUBE_FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
OCTAHEDRON = polyhedron(
    50 * np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]),
    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]],
)


def torus_grid(torus, across, around):
    """A grid of `across` by `around` quadrilaterals on a torus, anticlockwise seen from outside."""
    def point(i, j):
        u, v = 2 * np.pi * i / across, 2 * np.pi * j / around
        r = torus.ring + torus.tube * np.cos(v)
        return [float(x) for x in (r * np.cos(u), r * np.sin(u), torus.tube * np.sin(v))]

    nodes, curves, patches = {}, {}, {}
    for i in range(across):
        for j in range(around):
            right, up = (i + 1) % across, (j + 1) % around
            nodes[f"n{i}{j}"] = point(i, j)
            curves[f"h{i}{j}"] = line(f"n{i}{j}", f"n{right}{j}", on="surface", points=[point(i + 0.5, j)])
            curves[f"v{i}{j}"] = line(f"n{i}{j}", f"n{i}{up}", on="surface", points=[point(i, j + 0.5)])
            patches[f"p{i}{j}"] = {"around": [f"h{i}{j}", f"v{right}{j}", f"-h{i}{up}", f"-v{i}{j}"]}
    return {"nodes": nodes, "curves": curves, "patches": patches}


@pytest.mark.parametrize("rest", [{}, {"rest": "openings"}])
def test_a_slit_that_nothing_joins_is_named(tmp_path, rest):
    nodes, curves = square()
    nodes |= {"a": [10, 10, 0], "b": [20, 10, 0], "c": [20, 20, 0]}
    curves |= {"dart": line("a", "b", slit=True), "leg": line("b", "c", slit=True)}
    sections = {"nodes": nodes, "curves": flat(curves), "patches": {"p": {"around": SQUARE_AROUND}}, **rest}
    with pytest.raises(ProjectError, match="curve 'dart' and curve 'leg' are slits joined to no other curve"):
        network_of(tmp_path, **sections)
    curves["join"] = line("sw", "a", slit=True)
    around = [*SQUARE_AROUND, "join", "dart", "leg", "-leg", "-dart", "-join"]
    sections |= {"curves": flat(curves), "patches": {"p": {"around": around}}, "rest": "openings"}
    assert len(network_of(tmp_path, **sections).patches) == 1


def test_an_around_without_the_slit_in_it_is_told_where_that_belongs(tmp_path):
    """And not that the face is the other side of the loop."""
    nodes, curves = square()
    nodes |= {"tip": [10, 10, 0]}
    curves |= {"dart": line("sw", "tip", slit=True)}
    sections = {"nodes": nodes, "curves": flat(curves), "rest": "openings"}
    with pytest.raises(ProjectError, match="belong there, there and back") as caught:
        network_of(tmp_path, **sections, patches={"p": {"around": SQUARE_AROUND}})
    (problem,) = caught.value.problems
    around = yaml.safe_load(problem.message.split("back: ")[1])
    assert {"dart", "-dart"} < set(around) and "other way" not in problem.message
    assert len(network_of(tmp_path, **sections, patches={"p": {"around": around}}).patches) == 1


@pytest.mark.parametrize(
    ("sections", "faces"),
    [(TETRAHEDRON, 4), (polyhedron(CUBE_VERTICES, CUBE_FACES), 6), (OCTAHEDRON, 8)],
    ids=["tetrahedron", "cube", "octahedron"],
)
@pytest.mark.parametrize("mirrored", [False, True])
def test_polyhedra_have_their_faces(tmp_path, sections, faces, mirrored):
    network = network_of(tmp_path, **sections)
    assert (len(network.patches), network.face_count, network.euler_characteristics) == (faces, faces, (2,))
    assert not network.failed
    if mirrored:  # seen in a mirror the loops run clockwise, so that none is a face
        nodes = {name: [-x, y, z] for name, (x, y, z) in sections["nodes"].items()}
        curves = {
            name: {**curve, "normals": [-curve["normals"][0], *curve["normals"][1:]]}
            for name, curve in sections["curves"].items()
        }
        with pytest.raises(ProjectError, match="run the other way it is") as caught:
            network_of(tmp_path, nodes=nodes, curves=curves, patches=sections["patches"])
        assert sum("is no face" in problem.message for problem in caught.value.problems) == faces


def test_on_creases_every_face_of_a_cube_is_plane(tmp_path):
    network = network_of(tmp_path, **polyhedron(CUBE_VERTICES, CUBE_FACES, crease=True))
    for patch in network.patches:
        outward = patch.boundary.vertices.mean(axis=0) / 20
        assert patch.boundary.normals == pytest.approx(np.tile(outward, (len(patch.boundary.normals), 1)))
        assert excess(patch) == pytest.approx(0.0, abs=1e-12)


def test_patches_of_a_sphere_have_four_pi_of_curvature(tmp_path):
    """And with half the edges a quarter of the error."""
    curves = {
        name: {"from": curve["from"], "to": curve["to"], "on": "surface"}
        for name, curve in OCTAHEDRON["curves"].items()
    }
    off = []
    for edge_length in (10, 5):
        sections = {**OCTAHEDRON, "curves": curves, "edge_length": edge_length}
        network = network_of(tmp_path, Sphere(50.0), **sections)
        off.append(sum(map(excess, network.patches)) - 2 * np.pi * network.euler_characteristics[0])
    assert abs(off[0]) < 8 * 3 * (10 / 50) ** 2
    assert off[1] == pytest.approx(off[0] / 4, rel=0.1)


def test_torus_has_characteristic_0_and_no_curvature_in_all(tmp_path):
    torus = Torus(60.0, 25.0)
    network = network_of(tmp_path, torus, **torus_grid(torus, 5, 4))
    assert (len(network.patches), network.face_count, network.euler_characteristics) == (20, 20, (0,))
    assert not network.failed
    assert sum(map(excess, network.patches)) == pytest.approx(0.0, abs=20 * 4 * (10 / 25) ** 2)


def test_both_patches_along_a_stretch_hold_the_same_bits(tmp_path):
    torus = Torus(60.0, 25.0)
    network = network_of(tmp_path, torus, **torus_grid(torus, 5, 4))
    sides = {name: [] for name in network.stretches}
    for patch in network.patches:
        boundary, n = patch.boundary, len(patch.boundary.vertices)
        assert sum(s.count for s in boundary.stretches) == n
        for s in boundary.stretches:
            vertices = boundary.vertices[np.arange(s.first, s.first + s.count + 1) % n]
            normals = boundary.normals[s.first : s.first + s.count]
            sides[s.seam].append((vertices[::-1], normals[::-1]) if s.reversed else (vertices, normals))
    for name, (one, other) in sides.items():
        assert np.array_equal(one[0], other[0]) and np.array_equal(one[0], network.stretches[name].vertices)
        assert np.array_equal(one[1], other[1])


@pytest.mark.parametrize("seed", range(3))
def test_plane_triangulations_are_their_triangles(tmp_path, seed):
    """V - E + F = 2, every patch is anticlockwise, and together they cover the square."""
    points = 20.0 * np.stack(np.meshgrid(range(5), range(5)), axis=-1).reshape(-1, 2)
    inside = ((points > 0) & (points < 80)).all(axis=1)
    points[inside] += np.random.default_rng(seed).uniform(-8, 8, (inside.sum(), 2))
    mesh = Delaunay(points)
    nodes = {f"n{i}": [float(x), float(y), 0.0] for i, (x, y) in enumerate(points)}
    curves, patches = {}, {}
    for i, t in enumerate(mesh.simplices.tolist()):
        sides = list(zip(t, t[1:] + t[:1]))
        curves |= flat({f"e{a}_{b}": line(f"n{a}", f"n{b}") for a, b in map(sorted, sides)})
        patches[f"t{i}"] = {"around": [f"e{a}_{b}" if a < b else f"-e{b}_{a}" for a, b in sides]}
    network = network_of(tmp_path, nodes=nodes, curves=curves, patches=patches, rest="openings")
    assert (network.face_count, network.euler_characteristics) == (len(mesh.simplices) + 1, (2,))
    areas = []
    for patch in network.patches:
        x, y, _ = patch.boundary.vertices.T
        areas.append(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert min(areas) > 0
    assert sum(areas) == pytest.approx(80.0**2, rel=1e-12)


def test_curves_between_the_same_two_nodes_bound_a_face_each(tmp_path):
    nodes = {"a": [0, 0, 0], "b": [40, 0, 0]}
    curves = flat({"low": line("a", "b", points=[[20, -20, 0]]), "straight": line("a", "b"),
                   "high": line("a", "b", points=[[20, 20, 0]])})
    patches = {"lower": {"around": ["low", "-straight"]}, "upper": {"around": ["straight", "-high"]}}
    openings = {"outside": {"around": ["high", "-low"]}}
    network = network_of(tmp_path, nodes=nodes, curves=curves, patches=patches, openings=openings)
    assert (network.face_count, network.euler_characteristics) == (3, (2,))
    assert network.openings == {"outside": (("high", "-low"),)}


#: A snake that crosses a ladder four times: up, over the top, down, below the bottom, up ...
SNAKE = {
    "nodes": {f"{row}{i}": [20 * i, y, 0] for i in range(4) for row, y in (("b", 0), ("t", 20))},
    "curves": flat(
        {
            "bottom": line("b0", "b3", points=["b1", "b2"]),
            "top": line("t0", "t3", points=["t1", "t2"]),
            "snake": line(
                "b0",
                "b3",
                points=["t0", [10, 30, 0], "t1", "b1", [30, -10, 0], "b2", "t2", [50, 30, 0], "t3"],
            ),
        }
    ),
}
THIRD_FACE = ["bottom", "snake", "-top", "snake"]


class TestPlainNames:
    def build(self, tmp_path, around):
        patches = {"p": {"around": around}}
        return network_of(tmp_path, **SNAKE, patches=patches, rest="openings")

    def test_a_plain_name_may_stand_for_a_part_of_its_curve(self, tmp_path):
        [patch] = self.build(tmp_path, THIRD_FACE).patches
        assert [s.seam for s in patch.boundary.stretches] == [
            "bottom:b1..b2", "snake:b2..t2", "top:t1..t2", "snake:t1..b1"
        ]

    def test_where_it_fits_two_faces_both_are_printed_in_full(self, tmp_path):
        with pytest.raises(ProjectError, match="fits 2 faces") as caught:
            self.build(tmp_path, ["bottom", "-snake", "-top", "-snake"])
        message = str(caught.value)
        assert "[bottom:b0..b1, -snake:t1..b1, -top:t0..t1, -snake:b0..t0]" in message
        assert "[bottom:b2..b3, -snake:t3..b3, -top:t2..t3, -snake:b2..t2]" in message

    def test_one_stretch_named_is_enough_where_it_decides(self, tmp_path):
        [patch] = self.build(tmp_path, ["bottom:b2..b3", "-snake", "-top", "-snake"]).patches
        assert patch.boundary.stretches[3].seam == "snake:b2..t2"

    def test_a_name_may_span_several_stretches(self, tmp_path):
        for middle in ("snake", "snake:b1..b2"):
            [patch] = self.build(tmp_path, ["-bottom:b1..b2", middle]).patches
            assert [s.seam for s in patch.boundary.stretches] == ["bottom:b1..b2", "snake:b1..b2"]

    def test_over_a_node_without_another_curve_a_name_spans_both_sides(self, tmp_path):
        nodes, curves = square()
        nodes["m"] = [20, 0, 0]
        curves["south"]["points"] = ["m"]
        for first in ("south", "south:sw..se"):
            patches = {"p": {"around": [first, "east", "north", "west"]}}
            network = network_of(tmp_path, nodes=nodes, curves=flat(curves), patches=patches, rest="openings")
            assert [s.seam for s in network.patches[0].boundary.stretches[:2]] == ["south:sw..m", "south:m..se"]


class TestUnlisted:
    def test_what_is_printed_can_be_pasted(self, tmp_path):
        patches = {"face_1": {"around": THIRD_FACE}}
        with pytest.raises(ProjectError, match="listed neither under patches nor under openings") as caught:
            network_of(tmp_path, **SNAKE, patches=patches)
        openings = yaml.safe_load(caught.value.problems[0].message.split("\n", 1)[1])
        assert "face_1" not in openings  # the name is taken
        network = network_of(tmp_path, **SNAKE, patches=patches, openings=openings)
        assert len(network.openings) == network.face_count - 1

    def test_rest_openings_needs_no_list(self, tmp_path):
        nodes, curves = square()
        patches = {"p": {"around": SQUARE_AROUND}}
        network = network_of(tmp_path, nodes=nodes, curves=flat(curves), patches=patches, rest="openings")
        assert network.face_count == 2

    def test_a_face_has_one_owner(self, tmp_path):
        patches = {"p": {"around": THIRD_FACE}, "q": {"around": THIRD_FACE[2:] + THIRD_FACE[:2]}}
        with pytest.raises(ProjectError, match=r"patch 'q': the face .* already is patch 'p'"):
            network_of(tmp_path, **SNAKE, patches=patches, rest="openings")


class TestNoFace:
    def test_a_wrong_sign_or_a_missing_curve_prints_the_nearest_faces(self, tmp_path):
        nodes, curves = square()
        for around in (["south", "east", "-north", "west"], ["south", "east", "north"], ["south", "north"]):
            patches = {"p": {"around": around}}
            with pytest.raises(ProjectError, match="is no face of the network; the nearest faces") as caught:
                network_of(tmp_path, nodes=nodes, curves=flat(curves), patches=patches)
            nearest = str(caught.value).split("the nearest faces are ")[1]
            assert nearest.startswith("[south, east, north, west]")

    def test_all_problems_come_together_in_file_order(self, tmp_path):
        nodes, curves = square()
        patches = {"p": {"around": ["south", "east"]}, "q": {"around": ["-south", "-north"]}}
        with pytest.raises(ProjectError) as caught:
            network_of(tmp_path, nodes=nodes, curves=flat(curves), patches=patches)
        assert len(caught.value.problems) == 3  # p, q, and the two faces that are listed nowhere
        lines = [problem.mark.line for problem in caught.value.problems]
        assert lines == sorted(lines)


def test_a_network_of_openings_alone_is_refused(tmp_path):
    nodes, curves = square()
    openings = {
        "inside": {"around": SQUARE_AROUND},
        "outside": {"around": [f"-{name}" for name in reversed(SQUARE_AROUND)]},
    }
    with pytest.raises(ProjectError, match="no patch is left to make"):
        network_of(tmp_path, nodes=nodes, curves=flat(curves), openings=openings)
