"""A seeded family of boundaries of five kinds, with random sizes, amplitudes, waves and asymmetry."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flatnet.network.patch import BoundaryCurve
from tests.benchmark.boundaries import arc, boundary_curve, bowed, line, on_surface
from tests.benchmark.fits import edges_for

#: Boundaries of each kind, and the sizes of their meshes.
EACH = 40
FEWEST, MOST = 150, 700
#: Edge length of the mesh over that of the boundary.
RATIO = 1.25

Random = np.random.Generator


def quadrilateral(random: Random, width: float, height: float, bow: float):
    """The sides of a skewed rectangle round the origin, each bowed by up to `bow`."""
    corners = 0.5 * np.array([[-width, -height], [width, -height], [width, height], [-width, height]])
    corners += random.uniform(-0.12, 0.12, (4, 2)) * [width, height]
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return [bowed(line(a, b), random.uniform(-bow, bow)) for a, b in sides]


def wrinkles(random: Random):
    """The graph of a sine whose height and phase change across it."""
    width = random.uniform(1.2, 2.4)
    height = random.uniform(0.8, 1.8)
    amplitude = random.uniform(0.02, 0.18)
    waves = random.uniform(1.0, 5.0)
    growth, phase, slant = random.uniform(-0.5, 0.5), random.uniform(0.0, 2.0 * np.pi), random.uniform(-1.0, 1.0)

    def surface(q):
        x, y = q.T
        across = 2.0 * np.pi * waves * x / 2.4 + phase + slant * y
        return np.c_[x, y, amplitude * np.sin(across) * (1.0 + growth * 2.0 * y / height)]

    return quadrilateral(random, width, height, 0.1), surface


def saddles(random: Random):
    """A doubly curved graph that bends up along one axis and down along the other, a little cubic."""
    up, down = random.uniform(0.2, 1.4, 2)
    cubic = random.uniform(-0.5, 0.5, 2)

    def surface(q):
        x, y = q.T
        return np.c_[x, y, up * x**2 - down * y**2 + cubic[0] * x**3 + cubic[1] * x * y**2]

    return quadrilateral(random, random.uniform(0.8, 1.5), random.uniform(0.8, 1.5), 0.08), surface


def caps(random: Random):
    """An ellipsoid cut off along a wavy line round its pole."""
    half_angle = np.radians(random.uniform(12.0, 55.0))
    axes = random.uniform(0.7, 1.3, 3)
    heights, phases = random.uniform(-0.15, 0.15, 3), random.uniform(0.0, 2.0 * np.pi, 3)

    def surface(q):
        latitude, around = np.hypot(*q.T), np.arctan2(q[:, 1], q[:, 0])
        sine = np.sin(latitude)
        return axes * np.c_[sine * np.cos(around), sine * np.sin(around), np.cos(latitude)]

    def rim(t):
        around = 2.0 * np.pi * t
        radius = half_angle * (1.0 + sum(h * np.cos(k * around + p) for k, h, p in zip((1, 2, 3), heights, phases)))
        return np.c_[radius * np.cos(around), radius * np.sin(around)]

    return [rim], surface


def vamps(random: Random):
    """The U of a shoe's vamp, its arms of unequal length, on an ellipsoid that goes over into a cylinder."""
    length, height = random.uniform(1.2, 1.8), random.uniform(0.6, 1.0)
    outer, inner = random.uniform(0.85, 1.2), random.uniform(0.35, 0.6)
    left, right = random.uniform(0.4, 1.0, 2)
    back = -random.uniform(0.0, 0.3)

    def surface(q):
        p, s = q.T
        psi, omega = np.hypot(p, s), np.arctan2(s, p)
        toe = np.c_[length * np.sin(psi) * np.cos(omega), np.sin(psi) * np.sin(omega), height * np.cos(psi)]
        rear = np.c_[length * p, np.sin(s), height * np.cos(s)]
        return np.where((p > 0.0)[:, None], toe, rear)

    quarter = 0.5 * np.pi
    sides = [
        line((-left, -outer), (0, -outer)),
        arc((0, 0), outer, -quarter, quarter),
        line((0, outer), (-right, outer)),
        line((-right, outer), (-right, inner)),
        line((-right, inner), (back, inner)),
        arc((back, 0), inner, quarter, -quarter),
        line((back, -inner), (-left, -inner)),
        line((-left, -inner), (-left, -outer)),
    ]
    return sides, surface


def tubes(random: Random):
    """Part of a tapered tube, bent, its ends cut at a slant."""
    bend, length = random.uniform(1.5, 6.0), random.uniform(0.6, 1.6)
    start, taper = random.uniform(0.2, 0.4), random.uniform(-0.1, 0.1)
    opening, turn = np.radians(random.uniform(60.0, 190.0)), random.uniform(0.0, 2.0 * np.pi)

    def surface(q):
        around, s = q.T
        centre = np.c_[bend * np.sin(s / bend), 0 * s, bend * (np.cos(s / bend) - 1.0)]
        up = np.c_[np.sin(s / bend), 0 * s, np.cos(s / bend)]
        radius = (start + taper * s)[:, None]
        sideways = np.array([0.0, 1.0, 0.0])
        # With `around` against the usual sense, du x dv points out of the tube.
        angle = (turn - around)[:, None]
        return centre + radius * (np.cos(angle) * sideways + np.sin(angle) * up)

    sides = quadrilateral(random, opening, length, 0.0)
    return [lambda t, side=side: side(t) + [0.0, 0.5 * length] for side in sides], surface


KINDS: dict[str, Callable] = {
    "wrinkles": wrinkles, "saddles": saddles, "caps": caps, "vamps": vamps, "tubes": tubes,
}  # fmt: skip


def random_case(kind: str, number: int, vertices: float | None = None) -> tuple[BoundaryCurve, float]:
    """Boundary `number` of a kind, with its edge length, mm; the same at every call.

    `vertices` : about how many the mesh gets; left out, that is random too.
    """
    random = np.random.default_rng([list(KINDS).index(kind), number])
    sides, surface = KINDS[kind](random)
    size = random.uniform(60.0, 300.0)

    def make(n: int) -> BoundaryCurve:
        return boundary_curve(*on_surface(sides, surface, n), size)

    by_chance = float(np.exp(random.uniform(np.log(FEWEST), np.log(MOST))))
    boundary = make(edges_for(make, RATIO, vertices or by_chance))
    edges = np.linalg.norm(np.roll(boundary.vertices, -1, axis=0) - boundary.vertices, axis=1)
    return boundary, RATIO * float(edges.mean())
