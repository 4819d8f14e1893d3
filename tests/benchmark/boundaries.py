"""Eight boundary curves with normals, the common ground for measuring flattenable meshes; and a ninth for Fig. 7.

Each function takes the number of boundary edges n and returns (vertices (m, 3), edge normals (m, 3)),
anticlockwise seen against the normals, m close to n, corners kept. Lengths are in units of the shape (about 1 to 3).
"""

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline

from flatnet.geometry.triangles import unit
from flatnet.network.patch import BoundaryCurve, Stretch


def line(a, b):
    a, b = np.array(a, float), np.array(b, float)
    return lambda t: a + (b - a) * t[:, None]


def arc(centre, radius, start, end):
    def side(t):
        angle = start + (end - start) * t
        return np.c_[centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)]

    return side


def bowed(side, sag):
    return lambda t: side(t) + np.c_[0 * t, sag * np.sin(np.pi * t)]


def surface_normals(surface, q, step=1e-5):
    du = surface(q + [step, 0]) - surface(q - [step, 0])
    dv = surface(q + [0, step]) - surface(q - [0, step])
    return unit(np.cross(du, dv))


def on_surface(sides, surface, n):
    """Boundary through the sides of a parameter domain, n edges spread by length in space."""
    dense = []
    for side in sides:
        q = side(np.linspace(0, 1, 801))
        x = surface(q)
        dense.append((q, np.r_[0, np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))]))
    total = sum(d[-1] for _, d in dense)
    parts = []
    for q, d in dense:
        m = max(2, round(n * d[-1] / total))
        t = np.linspace(0, d[-1], m, endpoint=False)
        parts.append(np.c_[np.interp(t, d, q[:, 0]), np.interp(t, d, q[:, 1])])
    q = np.concatenate(parts)
    middle = 0.5 * (q + np.roll(q, -1, axis=0))
    return surface(q), surface_normals(surface, middle)


def wrinkle(n, amplitude=0.12, waves=5):
    """A 2 x 1.5 rectangle of the graph z = a sin(k pi x) (0.3 + 0.7 y); n / 4 edges a side."""

    def surface(q):
        x, y = q.T
        return np.c_[x, y, amplitude * np.sin(waves * np.pi * x) * (0.3 + 0.7 * y)]

    t = np.linspace(0, 1, n // 4, endpoint=False)
    q = np.c_[np.r_[2 * t, 2 + 0 * t, 2 - 2 * t, 0 * t], np.r_[0 * t, 1.5 * t, 1.5 + 0 * t, 1.5 - 1.5 * t]]
    vertices = surface(q)
    return vertices, surface_normals(surface, 0.5 * (q + np.roll(q, -1, axis=0)))


def saddle(n, h=0.35):
    """Unit square whose four sides are circular arcs, alternately bulging up and down by h."""
    radius = (h * h + 0.25) / (2 * h)

    def bulge(x):
        return np.sqrt(radius**2 - (x - 0.5) ** 2) - (radius - h)

    def surface(q):
        return np.c_[q, bulge(q[:, 0]) - bulge(q[:, 1])]

    sides = [line((0, 0), (1, 0)), line((1, 0), (1, 1)), line((1, 1), (0, 1)), line((0, 1), (0, 0))]
    return on_surface(sides, surface, n)


def vamp(n):
    """The U of a shoe's vamp, on an ellipsoid at the toe that goes over into a cylinder."""

    def surface(q):
        p, s = q[:, 0], q[:, 1]
        psi, omega = np.hypot(p, s), np.arctan2(s, p)
        toe = np.c_[1.5 * np.sin(psi) * np.cos(omega), np.sin(psi) * np.sin(omega), 0.8 * np.cos(psi)]
        rear = np.c_[1.5 * p, np.sin(s), 0.8 * np.cos(s)]
        return np.where((p > 0)[:, None], toe, rear)

    a, b = 1.05, 0.5
    sides = [
        line((-0.8, -a), (0, -a)),
        arc((0, 0), a, -np.pi / 2, np.pi / 2),
        line((0, a), (-0.8, a)),
        line((-0.8, a), (-0.8, b)),
        line((-0.8, b), (-0.2, b)),
        arc((-0.2, 0), b, np.pi / 2, -np.pi / 2),
        line((-0.2, -b), (-0.8, -b)),
        line((-0.8, -b), (-0.8, -a)),
    ]
    return on_surface(sides, surface, n)


def cap(n, half_angle_deg=40):
    """A circle of latitude of the unit sphere with the sphere's normals."""
    a = np.radians(half_angle_deg)
    t = np.arange(n) / n * 2 * np.pi

    def point(t):
        return np.c_[np.sin(a) * np.cos(t), np.sin(a) * np.sin(t), np.cos(a) + 0 * t]

    return point(t), point(t + np.pi / n)


def pants(n):
    """Half of a tapered tube, radius 0.30 to 0.18, bent with radius 2.2: a trouser panel with upright ends."""

    def surface(q):
        s, phi, bend = q[:, 0], q[:, 1], 2.2
        centre = np.c_[bend * np.sin(s / bend), 0 * s, bend * (np.cos(s / bend) - 1)]
        normal = np.c_[np.sin(s / bend), 0 * s, np.cos(s / bend)]
        across = np.array([0.0, 1.0, 0.0])
        radius = (0.30 - 0.08 * s)[:, None]
        return centre + radius * (np.cos(phi)[:, None] * across + np.sin(phi)[:, None] * normal)

    sides = [
        line((0, 0), (0, np.pi)),
        line((0, np.pi), (1.5, np.pi)),
        line((1.5, np.pi), (1.5, 0)),
        line((1.5, 0), (0, 0)),
    ]
    vertices, inwards = on_surface(sides, surface, n)
    return vertices, -inwards  # du x dv points into the tube; the loop is anticlockwise seen from outside


def cylinder(n):
    """A curved outline on the exact cylinder z = 0.15 sin 4x: a smooth developable solution is known."""

    def surface(q):
        return np.c_[q[:, 0], q[:, 1], 0.15 * np.sin(4 * q[:, 0])]

    sides = [
        bowed(line((0, 0), (2, 0.4)), -0.15),
        line((2, 0.4), (2.2, 1.5)),
        bowed(line((2.2, 1.5), (0.2, 1.2)), 0.2),
        line((0.2, 1.2), (0, 0)),
    ]
    return on_surface(sides, surface, n)


#: A broad body, an arm that hooks upwards, a second one to the right, a bay between.
HOOK = np.array(
    [
        [0.0, 0.1], [0.7, 0.0], [1.5, 0.1], [2.0, 0.05], [2.7, 0.05], [3.05, 0.25], [2.95, 0.55], [2.5, 0.6],
        [2.05, 0.65], [1.75, 0.95], [1.7, 1.3], [1.9, 1.6], [2.3, 1.65], [2.5, 1.85], [2.35, 2.15], [1.9, 2.2],
        [1.35, 2.0], [1.1, 1.6], [0.95, 1.25], [0.6, 1.1], [0.1, 1.0], [-0.15, 0.55],
    ]
)  # fmt: skip


def hook(n):
    """A strongly hollow outline, like Fig. 5 of the paper, on a doubly curved graph."""

    def surface(q):
        return np.c_[q, 0.9 * np.cos(0.9 * q[:, 0] - 1.2) + 0.75 * np.cos(1.1 * q[:, 1] - 1.2)]

    knots = np.arange(len(HOOK) + 1)
    outline = CubicSpline(knots, np.concatenate([HOOK, HOOK[:1]]), bc_type="periodic")
    return on_surface([lambda t: outline(knots[-1] * t)], surface, n)


#: name -> (boundary of n edges, target edge length of the planar mesh over the mean boundary edge)
CASES: dict[str, tuple[Callable, float]] = {
    "w05": (lambda n: wrinkle(n, 0.05), 1.3),
    "w12": (lambda n: wrinkle(n, 0.12), 1.3),
    "w20": (lambda n: wrinkle(n, 0.20), 1.3),
    "saddle": (saddle, 1.45),
    "vamp": (vamp, 0.83),
    "cap": (cap, 1.5),
    "pants": (pants, 1.2),
    "cylinder": (cylinder, 1.3),
}


#: As `CASES`: the outline of the paper's Fig. 5 and 7.
HOOKED: dict[str, tuple[Callable, float]] = {"hook": (hook, 0.9)}


def boundary_curve(vertices, normals, size=100.0) -> BoundaryCurve:
    """A boundary of one seam, `size` mm per unit, its normals made orthogonal to their edges."""
    edge = np.roll(vertices, -1, axis=0) - vertices
    normals = normals - edge * (np.sum(normals * edge, axis=1) / np.sum(edge**2, axis=1))[:, None]
    n = len(vertices)
    return BoundaryCurve(
        np.array(vertices) * size, unit(normals), (Stretch("boundary", 0, n, False),), np.zeros(n)
    )


def case(name: str, n: int) -> tuple[BoundaryCurve, float]:
    """One of `CASES` or `HOOKED` as a boundary curve, with its target edge length, mm."""
    make, ratio = (CASES | HOOKED)[name]
    boundary = boundary_curve(*make(n))
    edges = np.linalg.norm(np.roll(boundary.vertices, -1, axis=0) - boundary.vertices, axis=1)
    return boundary, ratio * float(edges.mean())
