"""The form `mannequin`: measurements of a body become its surface, from the ankles to the waist or to the neck."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from flatnet.forms.body import BODY_RINGS, LEG_RINGS, TORSO_RINGS, Body, rows_of_points, sections, with_bust
from flatnet.forms.measurements import MeasurementError, read_measurements
from flatnet.forms.surface import Line, ReferenceSurface, tidy_mesh
from flatnet.geometry.chains import boundary_edges, chains
from flatnet.geometry.polygon import arclengths

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Edge length of the mesh, mm: chords leave the ellipses by less than 0.1 mm.
GRID = 4.0
#: A grid vertex this near the sagittal plane, mm, is moved onto it, so that the cut leaves no slivers.
SNAP = 0.05

#: Measurements that only a body with its torso has.
OF_TORSO = (
    *("under_bust", "bust", "high_bust", "neck", "bust_span"),
    *("back_length", "shoulder", "back_width", "front_width"),
)


def mannequin(measurements: Mapping[str, float | str]) -> ReferenceSurface:
    """The surface of a `Body`: each girth (length of a tape around it), rise, inseam and back length are met.

    Its lines are the rings at the measured levels, from the front over the outside to the back, the lines
    `front`, `outside`, `back`, `inside` down a leg, and the rises in the sagittal plane; of a torso also
    `shoulder`, `side`, `centre_front` and `centre_back`. Its landmarks are where these meet (`knee_front`,
    `waist_centre_back`), and `crotch`, `bust_point`, `underarm`, `shoulder_point`, `across_front`,
    `across_back`. Of both halves together, what belongs to one half has `left_` or `right_` before its name.

    Raises
    ------
    MeasurementError
        Unknown names, impossible values, measurements of the torso without `top: neck`.
    """
    body = read_measurements(Body, measurements)
    unused = [name for name in OF_TORSO if name in measurements]
    if body.top == "waist" and unused:
        raise MeasurementError([f"{name} is measured above the waist; say `top: neck`" for name in unused])
    grid, row = _grid(body)
    vertices, triangles = _right_half(grid)
    landmarks, lines = _marks(body, grid, row, vertices, triangles)
    mirrored = _mirror(vertices), triangles[:, ::-1]
    mirrored_landmarks = {name: _mirror(point) for name, point in landmarks.items()}
    mirrored_lines = {name: _mirror(points) for name, points in lines.items()}
    if body.half == "left":
        vertices, triangles = mirrored
        landmarks, lines = mirrored_landmarks, mirrored_lines
    elif body.half == "both":
        triangles = np.concatenate([triangles, mirrored[1] + len(vertices)])
        vertices = np.concatenate([vertices, mirrored[0]])
        landmarks = _of_both(landmarks, mirrored_landmarks)
        rings = [name for name in (*BODY_RINGS, *TORSO_RINGS) if name in lines]
        whole = {name: np.vstack([lines[name], mirrored_lines[name][-2::-1]]) for name in rings}
        lines = whole | _of_both(
            *({name: points for name, points in half.items() if name not in whole} for half in (lines, mirrored_lines))
        )
    named = {name: Line(points) for name, points in lines.items()}
    return ReferenceSurface(tidy_mesh(vertices, triangles), landmarks, named)


def _mirror(points: Floats) -> Floats:
    """Points of one half, (..., 3), on the other one; 0 stays 0, never -0."""
    return points * [-1.0, 1.0, 1.0] + 0.0


def _of_both(right: dict[str, Floats], left: dict[str, Floats]) -> dict[str, Floats]:
    """What is named on both halves: once where it lies in the sagittal plane."""
    named = {}
    for name, points in right.items():
        if np.array_equal(points, left[name]):
            named[name] = points
        else:
            named |= {f"right_{name}": points, f"left_{name}": left[name]}
    return named


def _grid(body: Body) -> tuple[Floats, dict[str, int]]:
    """The tube of ellipses of the right half, not yet cut: rows from the ankle up, columns round it, (r, c, 3).

    Every level is a row, told by its name, and the crotch point a vertex. Column 0 is the outside, a quarter of
    the columns on the front, then the inside and the back.
    """
    levels = sorted(body.ways.values())
    rows = np.concatenate(
        [np.linspace(low, high, int(np.ceil((high - low) / GRID)), endpoint=False) for low, high in pairwise(levels)]
        + [[levels[-1]]]
    )
    points = rows_of_points(body, rows, 4 * int(np.ceil(body.thigh / GRID / 4)))
    if body.top == "neck":
        points = with_bust(body, points)
    points[np.abs(points[:, :, 0]) < SNAP, 0] = 0.0
    return points, {name: int(np.abs(rows - way).argmin()) for name, way in body.ways.items()}


def _right_half(grid: Floats) -> tuple[Floats, Ints]:
    """Vertices and triangles of the right half: the tube, cut off at the sagittal plane."""
    corner = np.arange(grid[:, :, 0].size).reshape(grid.shape[:2])
    right = np.roll(corner, -1, axis=1)
    lower_left, lower_right, upper_left, upper_right = (
        index.ravel() for index in (corner[:-1], right[:-1], corner[1:], right[1:])
    )
    triangles = np.concatenate(
        [
            np.stack([lower_left, lower_right, upper_right], axis=1),
            np.stack([lower_left, upper_right, upper_left], axis=1),
        ]
    )
    vertices, triangles, _ = trimesh.intersections.slice_faces_plane(
        grid.reshape(-1, 3), triangles, plane_normal=[1.0, 0.0, 0.0], plane_origin=[0.0, 0.0, 0.0]
    )
    vertices[np.abs(vertices[:, 0]) < 1e-9, 0] = 0.0  # the cut's vertices, off the plane by round-off
    return vertices, triangles


def _marks(
    body: Body, grid: Floats, row: dict[str, int], vertices: Floats, triangles: Ints
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Landmarks and lines of the right half, all on its mesh."""
    heights = body.heights
    quarter = grid.shape[1] // 4
    down = slice(None, None, -1)
    below = grid[: row["waist"] + 1]
    lines = {
        "front": _middle_line(body, below[:, : 2 * quarter + 1])[down],
        "outside": below[down, 0],
        "back": _middle_line(body, np.roll(below, -1, axis=1)[:, : 2 * quarter - 2 : -1])[down],
        "inside": grid[: row["crotch"] + 1, 2 * quarter][down],
    }

    # The rim in the sagittal plane runs from the centre front over the crotch to the centre back.
    mesh = tidy_mesh(vertices, triangles)
    at = np.asarray(mesh.vertices)
    rim = boundary_edges(np.asarray(mesh.faces))
    [cut] = chains(rim[(at[rim, 0] == 0.0).all(axis=1)])
    middle = at[cut] if at[cut[0], 1] > at[cut[-1], 1] else at[cut][down]
    lowest = int(middle[:, 2].argmin())
    centres = {"front": middle[: lowest + 1], "back": middle[lowest:][down]}
    for side, centre in centres.items():
        waist = int(np.abs(centre[:, 2] - heights["waist"]).argmin())
        lines[f"{side}_rise"] = centre[waist:]
        if body.top == "neck":
            lines[f"centre_{side}"] = centre[: waist + 1]

    landmarks = {"crotch": middle[lowest]}
    clockwise = (quarter - np.arange(grid.shape[1] + 1)) % grid.shape[1]  # seen from above, from the front on
    for name in LEG_RINGS:
        lines[name] = grid[row[name], clockwise]

    def around(name: str) -> Floats:
        """The ring of the half body at a level, from the centre front on."""
        inside_first = grid[row[name], (clockwise[:-1] + quarter) % grid.shape[1]]
        front, back = (next(p for p in centre if p[2] == heights[name]) for centre in centres.values())
        return np.vstack([front, inside_first[inside_first[:, 0] > 0.0], back])

    body_rings = BODY_RINGS + (TORSO_RINGS if body.top == "neck" else ())
    for name in body_rings:
        lines[name] = around(name)
        landmarks |= {f"{name}_centre_front": lines[name][0], f"{name}_centre_back": lines[name][-1]}
    for name in (*BODY_RINGS, *LEG_RINGS):
        sides = ("front", "outside", "back") + (("inside",) if name in LEG_RINGS else ())
        landmarks |= {f"{name}_{side}": next(p for p in lines[side] if p[2] == heights[name]) for side in sides}
    if body.top == "neck":
        lines["side"] = grid[row["waist"] : row["high_bust"] + 1, 0][down]
        lines["shoulder"] = grid[row["shoulder"] :, 0][down]
        across = around("across")
        landmarks |= {f"{name}_outside": grid[row[name], 0] for name in ("under_bust", "bust", "neck")} | {
            "underarm": grid[row["high_bust"], 0],
            "shoulder_point": grid[row["shoulder"], 0],
            "bust_point": _at_breadth(lines["bust"], body.bust_span / 2.0),
            "across_front": _along(across, body.front_width / 2.0),
            "across_back": _along(across[down], body.back_width / 2.0),
        }
    return landmarks, lines


def _along(points: Floats, way: float) -> Floats:
    """The point of a polyline this far along it."""
    along = arclengths(points)
    return np.array([np.interp(way, along, column) for column in points.T])


def _at_breadth(ring: Floats, breadth: float) -> Floats:
    """The first point of a ring, from the centre front on, this far from the sagittal plane."""
    end = int(np.argmax(ring[:, 0] > breadth)) + 1
    return np.array([np.interp(breadth, ring[:end, 0], ring[:end, axis]) for axis in range(3)])


def _middle_line(body: Body, side: Floats) -> Floats:
    """The line up the middle of the front or the back, (r, 3).

    In the middle of a leg, and of the half's breadth at hip and waist; between the levels a monotone cubic.

    Parameters
    ----------
    side : (r, k, 3) the columns of the grid from the outside to the inside.
    """
    levels = body.heights
    ellipses = {name: ellipse for name, ellipse in sections(body).items() if levels[name] <= levels["waist"]}
    across = {name: ellipse.cx for name, ellipse in ellipses.items()}
    across |= {name: (ellipses[name].cx + ellipses[name].a) / 2 for name in BODY_RINGS}
    order = sorted(across, key=lambda name: levels[name])
    z = side[:, 0, 2]
    x = PchipInterpolator([levels[name] for name in order], [across[name] for name in order])(z)
    y = [np.interp(at, row[::-1, 0], row[::-1, 1]) for at, row in zip(x, side)]
    return np.stack([x, y, z], axis=1)
