"""Networks without normals: what their curves' tangents tell about normals and faces."""

import numpy as np
import pytest
from drawn import SQUARE_AROUND, Sphere, Torus, line, network_of, project_of, square
from scipy.spatial.transform import Rotation
from test_faces import CUBE_FACES, CUBE_VERTICES, OCTAHEDRON, TETRAHEDRON, polyhedron, torus_grid

from flatnet.network.assembly import sample_stretches
from flatnet.network.tangents import normals_from_curves
from flatnet.project import ProjectError

CUBE = polyhedron(CUBE_VERTICES, CUBE_FACES)


def bare(sections, given=()):
    """The same curves without their normals and surface, but for those `given`."""
    def strip(curve):
        return {k: v for k, v in curve.items() if k not in ("on", "normals")} | {"normals": "curves"}

    curves = sections["curves"]
    return {**sections, "curves": {name: c if name in given else strip(c) for name, c in curves.items()}}


def moved(sections, turn):
    """A network of straight curves, moved."""
    return {**sections, "nodes": {n: (turn.apply(v) + [7, -20, 90]).tolist() for n, v in sections["nodes"].items()}}


def middles_and_normals(network):
    vertices = [stretch.vertices for stretch in network.stretches.values()]
    middles = np.concatenate([0.5 * (v[1:] + v[:-1]) for v in vertices])
    return middles, np.concatenate([stretch.left_normals for stretch in network.stretches.values()])


@pytest.mark.parametrize(
    ("sections", "faces"), [(TETRAHEDRON, 4), (CUBE, 6), (OCTAHEDRON, 8)], ids=["tetrahedron", "cube", "octahedron"]
)
def test_a_polyhedron_has_the_normals_that_its_symmetry_gives(sections, faces, tmp_path):
    """On each edge that from the centre through its middle; the patches listed with outer normals are its faces."""
    network = network_of(tmp_path, **bare(sections))
    assert (network.face_count, network.euler_characteristics, network.failed) == (faces, (2,), ())
    for stretch in network.stretches.values():
        outward = stretch.vertices[0] + stretch.vertices[-1]
        expected = np.broadcast_to(outward / np.linalg.norm(outward), stretch.left_normals.shape)
        np.testing.assert_allclose(stretch.left_normals, expected, atol=1e-12)


def test_normals_move_with_the_network(tmp_path):
    turn = Rotation.from_rotvec([0.4, -1.0, 2.0])
    _, still = middles_and_normals(network_of(tmp_path, **bare(CUBE)))
    _, turned = middles_and_normals(network_of(tmp_path, **moved(bare(CUBE), turn)))
    np.testing.assert_allclose(turned, turn.apply(still), atol=1e-12)


def test_the_order_of_curves_in_the_one_planar_embedding_goes_before_their_directions(tmp_path):
    """Two curves that change places as they leave a node of an octahedron."""
    sections = bare(OCTAHEDRON)
    a, b = "e01", "e02"  # both leave n0 = (50, 0, 0), for y and z
    curves = dict(sections["curves"])
    curves[a] = {**curves[a], "points": [[48, -1, 12], [30, 20, 1]]}
    curves[b] = {**curves[b], "points": [[48, 12, -1], [30, 1, 20]]}
    network = network_of(tmp_path, **{**sections, "curves": curves})
    assert (network.face_count, network.euler_characteristics) == (8, (2,))


def test_a_torus_is_no_planar_graph_and_is_told_from_its_tangents(tmp_path):
    torus = Torus(60, 20)
    sections = torus_grid(torus, 8, 6)
    curves = {name: {**c, "kind": "spline"} for name, c in sections["curves"].items()}
    network = network_of(tmp_path, **bare({**sections, "curves": curves}))
    assert (network.face_count, network.euler_characteristics, network.failed) == (48, (0,), ())
    middles, normals = middles_and_normals(network)
    assert np.einsum("ij,ij->i", normals, torus.nearest(middles)[1]).min() > 0.9


def meridians(count, radius=40.0):
    """Curves from pole to pole, each through points of a sphere."""
    along = np.linspace(0, np.pi, 17)
    curves = {}
    for k in range(count):
        turn = 2 * np.pi * k / count
        points = radius * np.stack(
            [np.sin(along) * np.cos(turn), np.sin(along) * np.sin(turn), np.cos(along)], axis=1
        )
        curves[f"m{k}"] = line("north", "south", kind="spline", points=points[1:-1].tolist(), normals="curves")
    around = {f"p{k}": {"around": [f"m{k}", f"-m{(k + 1) % count}"]} for k in range(count)}
    return {"nodes": {"north": [0, 0, radius], "south": [0, 0, -radius]}, "curves": curves, "patches": around}


@pytest.mark.parametrize("count", [3, 5])
def test_curves_between_the_same_two_nodes(count, tmp_path):
    """Not 3-connected, so the order around the poles is that in their tangent planes."""
    network = network_of(tmp_path, **meridians(count))
    assert (network.face_count, network.euler_characteristics) == (count, (2,))
    middles, normals = middles_and_normals(network)
    _, radial = Sphere(40).nearest(middles)
    # the directions of the first edges, not those of the curves, give the poles' tangent planes
    assert np.einsum("ij,ij->i", normals, radial).min() > np.cos(np.radians(1))


def flat_cross():
    """A square with a curve across it, in the plane."""
    nodes, curves = square()
    curves |= {"across": line("sw", "ne", points=[[15, 25, 0]])}
    curves = {name: {**curve, "normals": "curves"} for name, curve in curves.items()}
    patches = {"low": {"around": ["south", "east", "-across"]}, "high": {"around": ["across", "north", "west"]}}
    return {"nodes": nodes, "curves": curves, "patches": patches, "rest": "openings"}


def test_a_flat_network_is_seen_from_above(tmp_path):
    network = network_of(tmp_path, **flat_cross())
    assert network.face_count == 3 and not network.failed
    _, normals = middles_and_normals(network)
    np.testing.assert_allclose(normals, np.broadcast_to([0.0, 0.0, 1.0], normals.shape), atol=1e-12)


@pytest.mark.parametrize("turn", [[np.pi, 0, 0], [0, np.pi / 2, 0], [0, -np.pi / 2, 0], [np.pi / 2, 0, 0]])
def test_a_flat_network_is_seen_from_the_positive_side(turn, tmp_path):
    sections = flat_cross()
    sections["curves"]["across"].pop("points")
    project = project_of(tmp_path, **moved(sections, Rotation.from_rotvec(turn)))
    _, stretches, _, _ = sample_stretches(project, None)
    stretches, _, _ = normals_from_curves(stretches, project.curves, project.nodes)
    normals = np.concatenate([stretch.left_normals for stretch in stretches.values()])
    np.testing.assert_allclose(normals, np.broadcast_to(np.abs(normals[0]).round(), normals.shape), atol=1e-12)


@pytest.mark.parametrize("sections", [CUBE, OCTAHEDRON], ids=["cube", "octahedron"])
def test_one_given_normal_tells_the_side_of_all(sections, tmp_path):
    _, outward = middles_and_normals(network_of(tmp_path, **bare(sections)))
    name = next(iter(sections["curves"]))
    inward = (-np.array(sections["curves"][name]["normals"])).tolist()
    curves = {**bare(sections)["curves"], name: {**sections["curves"][name], "normals": inward}}
    patches = {n: {"around": [f"-{e}".replace("--", "") for e in reversed(p["around"])]}
               for n, p in sections["patches"].items()}
    _, turned = middles_and_normals(network_of(tmp_path, **{**sections, "curves": curves, "patches": patches}))
    assert np.einsum("ij,ij->i", turned, outward).max() < 0.0


def test_normals_turn_evenly_along_a_curve(tmp_path):
    """From that of one edge of a cube, given, to that of a corner: along the edge between them."""
    curves = {**bare(CUBE)["curves"], "e01": CUBE["curves"]["e01"]}
    normals = network_of(tmp_path, **{**CUBE, "curves": curves}).stretches["e13"].left_normals  # along y
    angles = np.degrees(np.arctan2(normals[:, 2], normals[:, 0]))
    start = np.degrees(np.arctan2(-1, 0))  # e01 leans to -y and -z
    steps = np.diff(angles, prepend=start, append=np.degrees(np.arctan2(-1, 1)))
    np.testing.assert_allclose(steps, 45 / 4 * np.array([0.5, 1, 1, 1, 0.5]), atol=1e-9)


def test_a_slit_keeps_its_place_in_a_planar_embedding(tmp_path):
    """A cut from a corner into the upper face of a cube."""
    sections = bare(CUBE)
    nodes = {**sections["nodes"], "tip": [5, 5, 20]}
    curves = {**sections["curves"], "cut": line("n7", "tip", slit=True, normals="curves")}
    patches = {**sections["patches"], "f4576": {"around": ["e45", "e57", "cut", "-cut", "-e67", "-e46"]}}
    network = network_of(tmp_path, nodes=nodes, curves=curves, patches=patches)
    assert (network.face_count, network.euler_characteristics, network.failed) == (6, (2,), ())


@pytest.mark.parametrize("nodes", [0, 1, 2], ids=["no node", "one node", "two nodes"])
def test_a_loop_without_corners_is_a_disc(nodes, tmp_path):
    turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.stack([30 * np.cos(turns), 30 * np.sin(turns), 3 * np.cos(2 * turns)], axis=1).tolist()
    curves = {
        0: {"ring": {"closed": True, "points": ring}},
        1: {"ring": line("a", "a", points=ring[1:])},
        2: {"ring": line("a", "b", points=ring[1:12]), "back": line("b", "a", points=ring[13:])},
    }[nodes]
    network = network_of(
        tmp_path,
        nodes={"a": ring[0], "b": ring[12]} if nodes else {},
        curves={name: {"kind": "spline", "normals": "curves", **curve} for name, curve in curves.items()},
        patches={"disc": {"around": list(curves)}},
        rest="openings",
    )
    assert not network.failed and network.face_count == 2
    _, normals = middles_and_normals(network)
    assert normals[:, 2].min() > 0.9


def test_two_loops_stay_two_parts(tmp_path):
    nodes, curves = square()
    nodes |= {f"{n}2": [x, y, 30] for n, (x, y, _) in nodes.items()}
    curves |= {f"{n}2": line(c["from"] + "2", c["to"] + "2") for n, c in curves.items()}
    curves = {name: {**curve, "normals": "curves"} for name, curve in curves.items()}
    patches = {"low": {"around": SQUARE_AROUND}, "high": {"around": [f"{n}2" for n in SQUARE_AROUND]}}
    with pytest.raises(ProjectError, match="ambiguous_faces: the network has 2 parts"):
        network_of(tmp_path, nodes=nodes, curves=curves, patches=patches)
    network = network_of(tmp_path, nodes=nodes, curves=curves, patches=patches, rest="openings")
    assert network.face_count == 4 and [patch.name for patch in network.patches] == ["low", "high"]


def test_curves_that_leave_in_all_directions_need_a_given_normal(tmp_path):
    """The spokes of an octahedron: with its edges no planar graph, and no plane at their hub."""
    spokes = {f"s{k}": line("hub", f"n{k}") for k in range(6)}
    sections = bare({**OCTAHEDRON, "curves": {**OCTAHEDRON["curves"], **spokes}})
    with pytest.raises(ProjectError, match=r"ambiguous_faces: node 'hub'.*leave in no common plane"):
        network_of(tmp_path, **{**sections, "nodes": {**sections["nodes"], "hub": [0, 0, 0]}})


def test_a_straight_way_there_and_back_shows_no_plane(tmp_path):
    curves = {"there": line("a", "b"), "back": line("b", "a", points=[[50, 0, 0]])}
    with pytest.raises(ProjectError, match="show no plane"):
        network_of(
            tmp_path,
            nodes={"a": [0, 0, 0], "b": [40, 0, 0]},
            curves={name: {**curve, "normals": "curves"} for name, curve in curves.items()},
            patches={"p": {"around": ["there", "back"]}},
            rest="openings",
        )
