"""Strips that cover themselves when they are laid flat."""

import numpy as np

from flatnet.geometry.triangles import dot, unit
from flatnet.network.network import CurveNetwork, SampledStretch
from flatnet.network.patch import BoundaryCurve, Patch, Stretch

EDGE = 12.0


def spiral(turns):
    """Inner and outer rim of a ring cut open that climbs as it goes round, (n, 3) each, mm."""
    t = np.linspace(0, 2 * np.pi * turns, int(40 * turns))
    return tuple(np.c_[r * np.cos(t), r * np.sin(t), 12 * t] for r in (60.0, 100.0))


def crossing_boundary(seed):
    """The rims of a random strip, wavy and of uneven width, that goes round more than once."""
    rng = np.random.default_rng(seed)
    turns = rng.uniform(1.05, 1.7)
    t = np.linspace(0, 2 * np.pi * turns, int(50 * turns))
    width, radius = rng.uniform(20, 45), 70 + 15 * rng.uniform(-1, 1) * np.cos(2 * t + rng.uniform(0, 6))
    height, wave = rng.uniform(5, 20) * t, rng.uniform(0, 25) * np.sin(2 * t)
    return tuple(
        np.c_[(radius + side * width) * np.cos(t), (radius + side * width) * np.sin(t), height + tilt * wave]
        for side, tilt in ((-0.5, 1.0), (0.5, 1.3))
    )


def ring_of(inner, outer):
    """The closed boundary, anticlockwise from above, with unit edge normals that point up."""
    vertices = np.concatenate([outer, inner[::-1]])
    edges = unit(np.roll(vertices, -1, axis=0) - vertices)
    up = np.array([0.0, 0.0, 1.0])
    return vertices, unit(up - (edges @ up)[:, None] * edges)


def network_of(inner, outer):
    """The network of one patch `strip` inside one closed curve."""
    vertices, normals = ring_of(inner, outer)
    n = len(vertices)
    rim = SampledStretch("rim", "rim", None, None, np.concatenate([vertices, vertices[:1]]), normals, normals)
    boundary = BoundaryCurve(vertices, normals, (Stretch("rim", 0, n, False),), np.zeros(n))
    return CurveNetwork({}, {"rim": rim}, (Patch("strip", boundary, EDGE, "cloth"),), (), {}, {}, 2, (2,))


def as_project(inner, outer):
    """A project file with that patch."""
    vertices, normals = ring_of(inner, outer)
    rim = {"closed": True, "points": vertices.tolist(), "normals": {"per": "segment", "values": normals.tolist()}}
    longest = np.linalg.norm(np.roll(vertices, -1, axis=0) - vertices, axis=1).max()
    return {
        "flatnet": 1,
        "name": "strip",
        "edge_length": float(np.ceil(longest)),
        "curves": {"rim": rim},
        "patches": {"strip": {"around": ["rim"], "grain": "none"}},
        "nesting": {"seconds": 1},
    }


def omega(tilt=0.9, body=310.0, curl=90.0, radius=80.0, small=40.0, width=20.0, edge=8.0):
    """A plane strip bent to the letter omega, with normals that tilt along its feet, as of a patch `omega`.

    The tilted normals predict that the feet curl outwards by less than they do in the plane, and so that they
    cross. Degrees, mm; `tilt` in rad.
    """
    heading, place = 0.0, np.zeros(2)
    middle, headings, tilts = [], [], []
    for degrees, r in ((-curl, small), (body, radius), (-curl, small)):
        length, turn = np.radians(abs(degrees)) * r, np.radians(degrees)
        count = int(length / edge)
        for _ in range(count):
            middle.append(place.copy())
            headings.append(heading)
            tilts.append(tilt if degrees < 0 else 0.0)
            half = heading + 0.5 * turn / count
            place += length / count * np.array([np.cos(half), np.sin(half)])
            heading += turn / count
    across = np.c_[-np.sin(headings), np.cos(headings)]
    right, left = middle - 0.5 * width * across, middle + 0.5 * width * across
    vertices = np.c_[np.concatenate([right, left[::-1]]), np.zeros(2 * len(middle))]
    lean, out = np.array([*tilts, *tilts[::-1]]), np.concatenate([across, across[::-1]])
    edges = unit(np.roll(vertices, -1, axis=0) - vertices)
    normals = np.c_[np.sin(lean)[:, None] * out, np.cos(lean)]
    normals = unit(normals - dot(edges, normals)[:, None] * edges)
    n = len(vertices)
    boundary = BoundaryCurve(vertices, normals, (Stretch("rim", 0, n, False),), np.zeros(n))
    return Patch("omega", boundary, edge, "cloth")
