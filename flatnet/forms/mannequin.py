"""The form `mannequin`: measurements of a lower body become its surface from the waist to the ankles.

z points up from the floor, y to the front, x to the body's right; the sagittal plane is x = 0. The right half's
section at height z is the part x >= 0 of an ellipse with centre (c_x, c_y) and half axes (a, b). Above the
crotch c_x < a: the sagittal plane cuts the ellipse. At the crotch c_x = a, below c_x > a: a closed leg.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.special import ellipe

from flatnet.forms.measurements import MeasurementError, read_measurements
from flatnet.forms.surface import Line, ReferenceSurface, tidy_mesh
from flatnet.geometry.chains import boundary_edges, chains

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Edge length of the mesh, mm: chords leave the ellipses by less than 0.1 mm.
GRID = 4.0
#: A grid vertex this near the sagittal plane, mm, is moved onto it, so that the cut leaves no slivers.
SNAP = 0.05


@dataclass(frozen=True)
class LowerBody:
    """Measurements of a lower body, mm.

    The defaults waist, hip, ankle, rise and inseam are those of a table of UK size 12 (720, 960, 240, crotch
    depth 280, inseam 760: together its waist to floor, 1040). That table has no thigh and no knee:
    FreeSewing's base set for women (570 and 380 at hip 1010) scaled to hip 960 gives 542 and 361. Neither has
    a calf: a little less than the knee is our own choice.

    Attributes
    ----------
    waist, hip : girths by tape around the whole body.
    thigh, knee, calf, ankle : girths of one leg.
    rise : height from crotch to waist (crotch depth).
    inseam : height from floor to crotch.
    half : `left` or `right` of the sagittal plane, or `both`.
    """

    waist: float = 720.0
    hip: float = 960.0
    thigh: float = 542.0
    knee: float = 361.0
    calf: float = 350.0
    ankle: float = 240.0
    rise: float = 280.0
    inseam: float = 760.0
    half: str = "both"

    def __post_init__(self) -> None:
        messages = []
        if self.half not in ("left", "right", "both"):
            messages.append(f"half must be left, right or both, got {self.half!r}")
        for smaller, larger in (("waist", "hip"), ("knee", "thigh"), ("calf", "thigh"), ("ankle", "calf")):
            girth, other = getattr(self, smaller), getattr(self, larger)
            if not 0.4 * other <= girth <= 1.2 * other:
                messages.append(
                    f"{smaller} must be 0.4 to 1.2 times {larger}, so in "
                    f"[{0.4 * other:.0f}, {1.2 * other:.0f}] mm, got {girth:g} mm"
                )
        thighs = _around_both(_section_at("thigh", self.thigh))
        if thighs > 1.05 * self.hip:
            messages.append(
                f"two thighs of {self.thigh:g} mm side by side measure {thighs:.0f} mm around, "
                f"more than the hip of {self.hip:g} mm; make hip larger or thigh smaller"
            )
        if messages:
            raise MeasurementError(messages)

    @property
    def heights(self) -> dict[str, float]:
        """Height of every measured level over the floor, mm.

        Hip: 206 / 280 of the rise below the waist; knee: 455 / 760 of the inseam (both UK 12; its waist to
        knee is 585 of 1040). Thigh 5 %, the calf's fullest place 57 %, the ankle 90 % of the inseam below the
        crotch: our own choices.
        """
        waist = self.inseam + self.rise
        return {
            "waist": waist,
            "hip": waist - 206.0 / 280.0 * self.rise,
            "crotch": self.inseam,
            "thigh": 0.95 * self.inseam,
            "knee": 455.0 / 760.0 * self.inseam,
            "calf": 0.43 * self.inseam,
            "ankle": 0.10 * self.inseam,
        }


@dataclass(frozen=True)
class Ellipse:
    """A horizontal section of the right half: centre (cx, cy), half axes a (across) and b (deep), mm."""

    cx: float
    cy: float
    a: float
    b: float


#: Level -> b / a, c_x / a, c_y / b of its ellipse: the figure's proportions, chosen by eye. The crotch level
#: has no girth of its own: a is that of the thigh, a little fuller.
PROPORTIONS = {
    "waist": (0.76, 0.05, 0.0),
    "hip": (0.90, 0.40, -0.10),
    "crotch": (1.11, 1.0, -0.05),
    "thigh": (1.10, 1.13, 0.02),
    "knee": (1.06, 1.33, 0.10),
    "calf": (1.02, 1.38, -0.16),
    "ankle": (1.20, 2.05, -0.30),
}
CROTCH_OVER_THIGH = 1.07


#: Levels whose ring goes round the body, and round a leg. At the crotch the legs touch: there is no ring.
BODY_RINGS = ("waist", "hip")
LEG_RINGS = ("thigh", "knee", "calf", "ankle")


def mannequin(measurements: Mapping[str, float | str]) -> ReferenceSurface:
    """The surface of a `LowerBody`: each girth (length of a tape around it), rise and inseam are met.

    Its lines are the rings at the measured levels, from the front over the outside to the back, the lines
    `front`, `outside`, `back`, `inside` down a leg, and the rises in the sagittal plane. Its landmarks are where
    these meet (`knee_front`, `waist_centre_back`), and the `crotch`. Of both halves together, what belongs to one
    half has `left_` or `right_` before its name.

    Raises
    ------
    MeasurementError
        Unknown names, impossible values.
    """
    body = read_measurements(LowerBody, measurements)
    grid = _grid(body)
    vertices, triangles = _right_half(grid)
    landmarks, lines = _marks(body, grid, vertices, triangles)
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
        whole = {name: np.vstack([lines[name], mirrored_lines[name][-2::-1]]) for name in BODY_RINGS}
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


def sections(body: LowerBody) -> dict[str, Ellipse]:
    """The ellipse of every level, its size solved for from the level's girth."""
    found = {name: _section_at(name, getattr(body, name)) for name in ("thigh", "knee", "calf", "ankle")}
    for name in ("waist", "hip"):
        depth, offset, _ = PROPORTIONS[name]
        found[name] = _scaled(name, getattr(body, name) / (_perimeter(1.0, depth) + 4.0 * offset))
    found["crotch"] = _scaled("crotch", CROTCH_OVER_THIGH * found["thigh"].a)
    return found


def profile(body: LowerBody, heights: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """c_x, c_y, a, b at each height, each (n,).

    Interpolated are the four silhouettes c_x -+ a and c_y -+ b, by monotone cubics: no bulge between two
    measured levels that neither has, and c_x - a changes its sign at the crotch alone.
    """
    levels = body.heights
    ellipses = sections(body)
    order = sorted(levels, key=lambda name: levels[name])
    at = [levels[name] for name in order]
    inner, outer, back, front = (
        PchipInterpolator(at, silhouette)(heights)
        for silhouette in np.transpose(
            [(e.cx - e.a, e.cx + e.a, e.cy - e.b, e.cy + e.b) for e in (ellipses[name] for name in order)]
        )
    )
    return (inner + outer) / 2, (back + front) / 2, (outer - inner) / 2, (front - back) / 2


def _scaled(name: str, a: float) -> Ellipse:
    depth, offset, shift = PROPORTIONS[name]
    return Ellipse(offset * a, shift * depth * a, a, depth * a)


def _section_at(name: str, girth: float) -> Ellipse:
    """The leg's ellipse at a level with this perimeter."""
    return _scaled(name, girth / _perimeter(1.0, PROPORTIONS[name][0]))


def _perimeter(a: float, b: float) -> float:
    long, short = max(a, b), min(a, b)
    return float(4.0 * long * ellipe(1.0 - (short / long) ** 2))


def _around_both(ellipse: Ellipse) -> float:
    """Length of a tape around the ellipse and its mirror image.

    Their hull is the ellipse swept by 2 c_x, and a swept convex curve is longer by twice the way.
    """
    return _perimeter(ellipse.a, ellipse.b) + 4.0 * ellipse.cx


def _grid(body: LowerBody) -> Floats:
    """The tube of ellipses of the right half, not yet cut: rows from the ankle up, columns round it, (r, c, 3).

    Every measured level is a row, and the crotch point a vertex. Column 0 is the outside, a quarter of the
    columns on the front, then the inside and the back.
    """
    levels = sorted(body.heights.values())
    rows = np.concatenate(
        [
            np.linspace(low, high, int(np.ceil((high - low) / GRID)), endpoint=False)
            for low, high in pairwise(levels)
        ]
        + [[levels[-1]]]
    )
    columns = 4 * int(np.ceil(body.thigh / GRID / 4))
    angles = 2.0 * np.pi * np.arange(columns) / columns
    cx, cy, a, b = (values[:, None] for values in profile(body, rows))
    x, y = cx + a * np.cos(angles), cy + b * np.sin(angles)
    x[np.abs(x) < SNAP] = 0.0
    return np.stack([x, y, np.broadcast_to(rows[:, None], x.shape)], axis=2)


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
    body: LowerBody, grid: Floats, vertices: Floats, triangles: Ints
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Landmarks and lines of the right half, all on its mesh."""
    heights = body.heights
    row = {name: int(np.abs(grid[:, 0, 2] - height).argmin()) for name, height in heights.items()}
    quarter = grid.shape[1] // 4
    down = slice(None, None, -1)
    lines = {
        "front": _middle_line(body, grid[:, : 2 * quarter + 1])[down],
        "outside": grid[down, 0],
        "back": _middle_line(body, np.roll(grid, -1, axis=1)[:, : 2 * quarter - 2 : -1])[down],
        "inside": grid[: row["crotch"] + 1, 2 * quarter][down],
    }

    # The rim in the sagittal plane runs from the centre front over the crotch to the centre back.
    mesh = tidy_mesh(vertices, triangles)
    at = np.asarray(mesh.vertices)
    rim = boundary_edges(np.asarray(mesh.faces))
    [cut] = chains(rim[(at[rim, 0] == 0.0).all(axis=1)])
    rises = at[cut] if at[cut[0], 1] > at[cut[-1], 1] else at[cut][down]
    lowest = int(rises[:, 2].argmin())
    lines["front_rise"], lines["back_rise"] = rises[: lowest + 1], rises[lowest:][down]

    landmarks = {"crotch": rises[lowest]}
    clockwise = (quarter - np.arange(grid.shape[1] + 1)) % grid.shape[1]  # seen from above, from the front on
    for name in LEG_RINGS:
        lines[name] = grid[row[name], clockwise]
    for name in BODY_RINGS:
        around = grid[row[name], (clockwise[:-1] + quarter) % grid.shape[1]]  # from the inside on
        ends = [
            next(p for p in rise if p[2] == heights[name]) for rise in (lines["front_rise"], lines["back_rise"])
        ]
        lines[name] = np.vstack([ends[0], around[around[:, 0] > 0.0], ends[1]])
        landmarks |= {f"{name}_centre_front": ends[0], f"{name}_centre_back": ends[1]}
    for name in (*BODY_RINGS, *LEG_RINGS):
        sides = ("front", "outside", "back") + (("inside",) if name in LEG_RINGS else ())
        landmarks |= {
            f"{name}_{side}": next(p for p in lines[side] if p[2] == heights[name]) for side in sides
        }
    return landmarks, lines


def _middle_line(body: LowerBody, side: Floats) -> Floats:
    """The line up the middle of the front or the back, (r, 3).

    In the middle of a leg, and of the half's breadth at hip and waist; between the levels a monotone cubic.

    Parameters
    ----------
    side : (r, k, 3) the columns of the grid from the outside to the inside.
    """
    levels = body.heights
    across = {name: ellipse.cx for name, ellipse in sections(body).items()}
    across |= {name: (ellipse.cx + ellipse.a) / 2 for name, ellipse in sections(body).items() if name in BODY_RINGS}
    order = sorted(levels, key=lambda name: levels[name])
    z = side[:, 0, 2]
    x = PchipInterpolator([levels[name] for name in order], [across[name] for name in order])(z)
    y = [np.interp(at, row[::-1, 0], row[::-1, 1]) for at, row in zip(x, side)]
    return np.stack([x, y, z], axis=1)
