"""Networks for tests: project files from dicts, and surfaces with a formula."""

import numpy as np
import trimesh
import yaml

from flatnet.forms.surface import ReferenceSurface, tidy_mesh
from flatnet.geometry.polygon import predicted_angles
from flatnet.network.assembly import make_network, sample_stretches
from flatnet.project import load_project


class Sphere:
    """Round the origin."""

    def __init__(self, radius):
        self.radius = radius

    def nearest(self, points):
        normals = points / np.linalg.norm(points, axis=1, keepdims=True)
        return self.radius * normals, normals


class Cylinder:
    """Round the z axis."""

    def __init__(self, radius):
        self.radius = radius

    def nearest(self, points):
        normals = points * [1, 1, 0]
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        return self.radius * normals + points * [0, 0, 1], normals


class Torus:
    """Round the z axis; `ring` is the radius of its core, `tube` that around it."""

    def __init__(self, ring, tube):
        self.ring, self.tube = ring, tube

    def nearest(self, points):
        core = points * [1, 1, 0]
        core = self.ring * core / np.linalg.norm(core, axis=1, keepdims=True)
        normals = (points - core) / np.linalg.norm(points - core, axis=1, keepdims=True)
        return core + self.tube * normals, normals


class Valley:
    """z = |x|."""

    def nearest(self, points):
        side = np.where(points[:, 0] < 0, -1.0, 1.0)
        along = 0.5 * (side * points[:, 0] + points[:, 2])
        feet = np.stack([side * along, points[:, 1], along], axis=1)
        return feet, np.stack([-side, 0 * side, 1 + 0 * side], axis=1) / np.sqrt(2)


def project_of(folder, surface=None, **sections):
    """The project of a file with these sections; `surface` only makes the words `on: surface` legal."""
    sections = {"flatnet": 1, "name": "drawn", "edge_length": 10, **sections}
    if surface is not None:
        sections["surface"] = {"form": "mannequin"}
    file = folder / "project.yaml"
    file.write_text(yaml.safe_dump(sections, sort_keys=False))
    return load_project(file)


def network_of(folder, surface=None, **sections):
    return make_network(project_of(folder, surface, **sections), surface)


def stretches_of(folder, surface=None, **sections):
    """The sampled stretches of curves that need not bound anything, and what is wrong with the others."""
    sections["patches"] = {"unused": {"around": [next(iter(sections["curves"]))]}}
    project = project_of(folder, surface, **sections)
    _, stretches, _, problems = sample_stretches(project, surface)
    return stretches, [problem.message for problem in problems]


def excess(patch):
    """sum(alpha) - (n - 2) pi: the total curvature of the patch (Gauss-Bonnet)."""
    alpha, _ = predicted_angles(patch.boundary.vertices, patch.boundary.normals)
    return alpha.sum() - (len(alpha) - 2) * np.pi


UP = [0, 0, 1]


def flat(curves):
    """Curves of the plane z = 0, seen from above."""
    return {name: {"normals": UP, **curve} for name, curve in curves.items()}


def line(a, b, **rest):
    return {"from": a, "to": b, **rest}


def square(side=40.0):
    """Nodes and curves of a square, anticlockwise: south, east, north, west."""
    nodes = {"sw": [0, 0, 0], "se": [side, 0, 0], "ne": [side, side, 0], "nw": [0, side, 0]}
    curves = {"south": line("sw", "se"), "east": line("se", "ne"), "north": line("ne", "nw"),
              "west": line("nw", "sw")}
    return nodes, curves


SQUARE_AROUND = ["south", "east", "north", "west"]


def prism(columns=48, radius=50.0, height=200.0, rows=20):
    """An open tube of flat strips round the z axis, z from 0 to height; its unrolled length is 2 n R sin(pi / n)."""
    angles = 2 * np.pi * np.arange(columns) / columns
    z = np.linspace(0.0, height, rows + 1)
    ring = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    vertices = np.column_stack([np.tile(ring, (rows + 1, 1)), np.repeat(z, columns)])
    corner = np.arange(len(vertices)).reshape(rows + 1, columns)
    a, b, c, d = (x.ravel() for x in (corner[:-1], np.roll(corner, -1, 1)[:-1], np.roll(corner, -1, 1)[1:], corner[1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return ReferenceSurface(tidy_mesh(vertices, triangles))


def ball(radius=50.0, subdivisions=4):
    mesh = trimesh.creation.icosphere(subdivisions, radius)
    return ReferenceSurface(tidy_mesh(mesh.vertices, mesh.faces))


def sheet(size=100.0, count=10):
    """A square of the plane z = 0."""
    x, y = np.meshgrid(*2 * [np.linspace(0.0, size, count + 1)], indexing="ij")
    corner = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (k.ravel() for k in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return ReferenceSurface(tidy_mesh(np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]), triangles))


def box(*size):
    mesh = trimesh.creation.box(size)
    return ReferenceSurface(tidy_mesh(mesh.vertices, mesh.faces))
