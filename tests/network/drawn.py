"""Networks for tests: project files from dicts, and surfaces with a formula."""

import numpy as np
import yaml

from flatnet.geometry.polygon import predicted_angles
from flatnet.network.assembly import make_network, sample_stretches
from flatnet.network.curves import place_nodes
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
    places = place_nodes(project.nodes, project.curves, surface)
    stretches, problems = sample_stretches(project, places, surface)
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
