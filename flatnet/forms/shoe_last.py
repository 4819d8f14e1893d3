"""The form `shoe_last`: size, girths and heel of a last become its upper surface, from feather edge to cone.

x points from the heel to the toe, y to the left, z up from the ground; a right last has its inner side at +y.
The surface is a cubic B-spline: rows of its control net run across, from the inner feather edge over the ridge to
the outer one, and follow each other from heel to toe. The first and the last row each fold into one line, the
curves of heel and toe. The bottom is open along the feather edge, the cone along a level cut.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.optimize import root
from scipy.spatial import ConvexHull

from flatnet.forms.last_tables import (
    ACROSS_HEIGHTS,
    ARCH_RISE,
    HEEL_LEAN,
    INNER_FEATHER,
    INNER_SWELL,
    LEAN_FADES,
    LENGTH,
    OUTER_FEATHER,
    OUTER_SWELL,
    RIDGE,
    RIDGE_SHIFT,
    ROOF,
    ROWS,
    TOE_LEAN,
    TOES,
    WALL,
)
from flatnet.forms.measurements import MeasurementError, read_measurements
from flatnet.forms.surface import Line, ReferenceSurface, tidy_mesh
from flatnet.geometry.chains import boundary_edges, chains
from flatnet.geometry.polygon import arclengths
from flatnet.geometry.triangles import unit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Length of the last per size, mm: the Paris point (ISO/TS 19407).
PER_SIZE = 20.0 / 3.0
#: Edge length of the mesh, mm.
GRID = 3.0
#: A vertex this near the cone's cut, mm, is moved onto it, so that the cut leaves no slivers.
SNAP = 0.05
#: Percent of the length at which the girth lines lie.
STATIONS = tuple(range(5, 100, 5))
#: x of the feather's ends of the ball line, and of the instep point on the ridge and the bottom below it, as parts
#: of the length. The cone's cut lies this part of the length over the heel.
INNER_BALL, OUTER_BALL = 0.72, 0.625
INSTEP_POINT, INSTEP_BOTTOM = 0.43, 0.30
CONE_HEIGHT = 0.345
#: Girths are met to this, relative.
GIRTH_TOLERANCE = 1e-6


@dataclass(frozen=True)
class ShoeLast:
    """Measurements of a last, mm; what is None follows from size and heel (`of_size`).

    Attributes
    ----------
    size : Paris points; the length of the last is 20 / 3 mm times it.
    ball, waist, instep : girths by tape, the bottom included.
    tread, seat : widths of the bottom, from feather edge to feather edge, at the ball and at the heel.
    heel : height of the heel seat over the ground.
    spring : height of the toe point over the ground.
    toe : `round`, `almond`, `pointed` or `square`.
    side : `right` or `left`, its mirror image.
    halves : `own`, or `mean`: inner and outer half averaged into one, the mean forme.
    """

    size: float = 42.0
    ball: float | None = None
    waist: float | None = None
    instep: float | None = None
    tread: float | None = None
    seat: float | None = None
    heel: float = 35.0
    spring: float | None = None
    toe: str = "round"
    side: str = "right"
    halves: str = "own"

    def __post_init__(self) -> None:
        words = {"toe": tuple(TOES), "side": ("left", "right"), "halves": ("own", "mean")}
        messages = [
            f"{name} must be {', '.join(known[:-1])} or {known[-1]}, got {getattr(self, name)!r}"
            for name, known in words.items()
            if getattr(self, name) not in known
        ]
        if not 16.0 <= self.size <= 52.0:
            messages.append(f"size must be in [16, 52], got {self.size:g}")
        else:
            ranges = {"heel": (0.0, 0.25 * self.length), "spring": (0.0, 0.1 * self.length)}
            for name, usual in self.of_size.items():
                ranges.setdefault(name, (0.8 * usual, 1.25 * usual))
            for name, (low, high) in ranges.items():
                value = getattr(self, name)
                if value is not None and not low <= value <= high:
                    messages.append(
                        f"{name} must be in [{low:.0f}, {high:.0f}] mm at size {self.size:g}, got {value:g} mm"
                    )
        if messages:
            raise MeasurementError(messages)

    @property
    def length(self) -> float:
        """Of the last, from heel to toe along x."""
        return PER_SIZE * self.size

    @property
    def of_size(self) -> dict[str, float]:
        """What is left out: girths grow by 5 mm a size (6.35 mm an English one, of 8.47 mm length).

        The toe springs less over a higher heel.
        """
        girths = {"ball": 247.0, "waist": 235.0, "instep": 253.0}
        grown = {name: girth + 5.0 * (self.size - 42.0) for name, girth in girths.items()}
        return {
            **grown,
            "tread": 0.355 * (self.ball or grown["ball"]),
            "seat": 0.225 * self.length,
            "spring": max(3.0, 12.5 - 0.1 * self.heel),
        }

    def measured(self, name: str) -> float:
        """A measurement that is given, else the size's."""
        given: float | None = getattr(self, name)
        return self.of_size[name] if given is None else given


def shoe_last(measurements: Mapping[str, float | str]) -> ReferenceSurface:
    """The surface of a `ShoeLast`: length, girths and widths of the bottom are met.

    Its lines: `feather` and `cone_edge`, its rims; `back_line` and `front_line` down heel and ridge; `ball_line`,
    `waist_line` and `instep_line`, where the girths are taken; `inner_5` to `outer_95`, from the feather edge up at
    every twentieth of the length. Its landmarks are the points that these are measured by.

    Raises
    ------
    MeasurementError
        Unknown names, impossible values, girths that do not go together.
    """
    last = read_measurements(ShoeLast, measurements)
    grid = _grid(last, _fullness(last))
    height = last.heel + CONE_HEIGHT * last.length
    near = np.abs(grid[..., 2] - height) < SNAP
    grid[near, 2] = height
    mesh = _mesh(grid, height)
    landmarks, lines = _marks(last, grid, mesh, height)
    if last.side == "left":
        mesh = trimesh.Trimesh(_mirror(mesh.vertices), mesh.faces[:, ::-1], process=False)
        landmarks = {name: _mirror(point) for name, point in landmarks.items()}
        lines = {name: _mirror(points) for name, points in lines.items()}
    return ReferenceSurface(mesh, landmarks, {name: Line(points) for name, points in lines.items()})


def _mirror(points: Floats) -> Floats:
    """Points of a right last, (..., 3), on the left one; 0 stays 0, never -0."""
    return np.asarray(points) * [1.0, -1.0, 1.0] + 0.0


def girths(last: ShoeLast, grid: Floats) -> Floats:
    """Ball, waist and instep girth of a surface, (3,) mm: lengths of a tape round its sections."""
    return np.array([_tape(grid, point, normal) for point, normal in _girth_planes(last, grid).values()])


def _net(last: ShoeLast, fullness: Floats, tread: float = 1.0, seat: float = 1.0) -> Floats:
    """The control net of a right last, (rows, 11, 3) mm: inner feather edge, ridge, outer feather edge.

    `fullness`: of ball, waist and instep, by which widths and heights are scaled; `tread`, `seat`: the same of
    the feather edge's widths.
    """
    scale = last.length / LENGTH
    feather = np.stack([INNER_FEATHER, -OUTER_FEATHER])
    swell = np.stack([INNER_SWELL, -OUTER_SWELL])
    rise = np.stack([ARCH_RISE, np.zeros_like(ARCH_RISE)])
    ridge = RIDGE_SHIFT
    if last.halves == "mean":
        feather, swell, rise = (
            (values + sign * values[::-1]) / 2 for values, sign in ((feather, -1), (swell, -1), (rise, 1))
        )
        ridge = np.zeros_like(ridge)
    middle = feather.mean(axis=0)
    bluntness = np.ones(len(ROWS))
    bluntness[-1 - len(TOES[last.toe]) : -1] = TOES[last.toe]
    feather = middle + bluntness * (feather - middle)
    wall = feather + swell

    full = _along(ROWS, fullness)
    feather *= np.interp(ROWS, [92.0, 148.0], [seat, tread])
    net = np.empty((len(ROWS), 11, 3))
    ground = _feather_height(last, scale * ROWS)
    lean = np.exp(-ROWS / LEAN_FADES)[:, None] * HEEL_LEAN - np.exp((ROWS - LENGTH) / LEAN_FADES)[:, None] * TOE_LEAN
    for half, columns in enumerate((slice(0, 6), slice(10, 4, -1))):
        upper = ridge + np.stack([WALL, ROOF]) * (wall[half] - ridge)
        across = np.stack([feather[half], *(full * [wall[half], wall[half], *upper, ridge])], axis=1)
        net[:, columns, 0] = scale * (ROWS[:, None] + lean)
        net[:, columns, 1] = scale * across
        net[:, columns, 2] = (
            ground[:, None]
            + scale * (full * RIDGE)[:, None] * ACROSS_HEIGHTS
            + scale * rise[half][:, None] * (1.0 - ACROSS_HEIGHTS)
        )
    # Where the ridge meets the fold of the toe, the surface is smooth only if it goes on straight there: the end of
    # the ridge, its last place before (of the spline, not of the net) and the roof beside it lie on one line.
    before, end = (net[-3, 4] + 4.0 * net[-3, 5] + net[-3, 6]) / 6.0, net[-1, 5]
    for roof in (4, 6):
        beyond = (net[-1, roof, 0] - end[0]) / (end[0] - before[0])
        net[-2:, roof, 2] = end[2] + beyond * (end[2] - before[2])
    return net


def _along(rows: Floats, fullness: Floats) -> Floats:
    """Fullness at x of the base last: that of each girth around it, half of the instep's at the heel."""
    ball, waist, instep = np.log(fullness)
    return np.exp(np.interp(rows, [36.0, 92.0, 140.0, 186.0], [instep / 2, instep, waist, ball]))


def _feather_height(last: ShoeLast, x: Floats) -> Floats:
    """z of the feather edge: level under heel and tread, between them a smooth step, towards the toe the spring."""
    part = np.clip((x / last.length - 0.16) / 0.5, 0.0, 1.0)
    step = part**3 * (10.0 - 15.0 * part + 6.0 * part**2)
    spring = np.clip((x / last.length - 0.66) / 0.34, 0.0, None) ** 2.2
    return last.heel * (1.0 - step) + last.measured("spring") * spring


@cache
def _basis(controls: int, parameters: tuple[float, ...]) -> Floats:
    """Cubic B-splines over uniform knots, clamped: (parameters, controls), parameters in [0, controls - 3]."""
    knots = np.concatenate([[0.0] * 3, np.arange(controls - 2.0), [controls - 3.0] * 3])
    return np.asarray(BSpline.design_matrix(np.array(parameters), knots, 3).toarray())


@cache
def _rows(length: float) -> tuple[tuple[float, ...], tuple[int, ...]]:
    """Parameters of the grid's rows from heel to toe, and which of them are the stations."""
    spans = len(ROWS) - 3
    dense = np.linspace(0.0, spans, 2001)
    x = _basis(len(ROWS), tuple(dense)) @ ROWS / LENGTH
    stations = [0.0, *np.interp(np.array(STATIONS) / 100.0, x, dense), float(spans)]
    # Heel and toe turn by a quarter within the first and the last station: rows twice as dense.
    counts = [int(np.ceil((2.0 if i in (0, len(STATIONS)) else 1.0) * 0.05 * length / GRID)) for i in range(20)]
    parts = [
        np.linspace(low, high, count, endpoint=False)
        for low, high, count in zip(stations[:-1], stations[1:], counts, strict=True)
    ]
    return (*np.concatenate(parts), float(spans)), tuple(np.cumsum(counts)[:-1])


def _grid(last: ShoeLast, fullness: Floats) -> Floats:
    """Points of the surface, (rows, columns, 3) mm, the middle column on the ridge."""
    rows, _ = _rows(last.length)
    columns = 2 * int(np.ceil(0.5 * 1.1 * last.measured("instep") / GRID))
    across = _basis(11, tuple(np.linspace(0.0, 8.0, columns + 1)))
    lengthwise = _basis(len(ROWS), rows)

    def surface(net: Floats) -> Floats:
        return np.einsum("ui,ijk,tj->utk", lengthwise, net, across)

    edge = surface(_net(last, np.ones(3)))[:, [0, -1], 1]
    x = lengthwise @ ROWS / LENGTH
    tread = last.measured("tread") / np.ptp(edge[x > 0.5])
    seat = last.measured("seat") / np.ptp(edge[x < 0.25])
    grid = surface(_net(last, fullness, tread, seat))
    # Both halves of a folded row are one line, to the last bit.
    for row in (grid[0], grid[-1]):
        row[:] = (row + row[::-1]) / 2
    grid[..., 0] = (grid[..., 0] - grid[..., 0].min()) * last.length / np.ptp(grid[..., 0])
    return grid


def _fullness(last: ShoeLast) -> Floats:
    """The fullness of ball, waist and instep with which the girths are met, (3,)."""
    wanted = np.array([last.measured(name) for name in ("ball", "waist", "instep")])

    def error(logarithms: Floats) -> Floats:
        return np.log(girths(last, _grid(last, np.exp(logarithms))) / wanted)

    found = root(error, np.zeros(3), options={"xtol": GIRTH_TOLERANCE})
    if not np.abs(found.fun).max() < 100 * GIRTH_TOLERANCE:
        raise MeasurementError(["no last has these girths together; ball, waist and instep differ too much"])
    return np.exp(found.x)


def _at_x(line: Floats, x: float) -> Floats:
    """The point of a line that runs from heel to toe at this x, (3,)."""
    return np.array([np.interp(x, line[:, 0], column) for column in line.T])


def _ridge(grid: Floats) -> Floats:
    return grid[:, grid.shape[1] // 2]


def _points(last: ShoeLast, grid: Floats) -> dict[str, Floats]:
    """The points that the last is measured by, on the lines of its grid."""
    length = last.length
    edge = _feather_height(last, np.linspace(0.0, length, 1001))
    standard = float(np.hypot(length / 1000, np.diff(edge)).sum())  # SLL, by tape along the bottom
    back = grid[0, : grid.shape[1] // 2 + 1]
    toe = grid[-1, : grid.shape[1] // 2 + 1]
    up = arclengths(back)

    def on_back(height: float) -> Floats:
        return np.array([np.interp(height, up, column) for column in back.T])

    counter = on_back(standard / 5 + 3.0)
    ridge = _ridge(grid)
    distance = np.linalg.norm(ridge - counter, axis=1)
    ahead = ridge[:, 0] > 0.4 * length
    vamp = np.array([np.interp(0.75 * standard, distance[ahead], column) for column in ridge[ahead].T])
    instep = _at_x(ridge, INSTEP_POINT * length)
    inner, outer = (INNER_BALL, OUTER_BALL) if last.halves == "own" else ((INNER_BALL + OUTER_BALL) / 2,) * 2
    return {
        "heel_point": back[0],
        "counter_point": counter,
        "back_height": on_back(standard / 5 + 3.0 + 8.5),
        "toe_point": toe[0],
        "vamp_point": vamp,
        "waist_point": _at_x(ridge, (vamp[0] + instep[0]) / 2),
        "instep_point": instep,
        "inner_ball": _at_x(grid[:, 0], inner * length),
        "outer_ball": _at_x(grid[:, -1], outer * length),
    }


def _girth_planes(last: ShoeLast, grid: Floats) -> dict[str, tuple[Floats, Floats]]:
    """Point and unit normal, towards the toe, of the planes of ball, waist and instep girth.

    The ball's passes inner ball, vamp point and outer ball; the others lean with the ridge and run straight
    across, the waist's half way between.
    """
    points = _points(last, grid)
    bottom_ball = (points["inner_ball"] + points["outer_ball"]) / 2
    across = points["inner_ball"] - points["outer_ball"]
    planes = {"ball": (points["vamp_point"], unit(np.cross(across, points["vamp_point"] - bottom_ball)))}
    bottoms = {"waist": (INSTEP_BOTTOM * last.length + bottom_ball[0]) / 2, "instep": INSTEP_BOTTOM * last.length}
    for name, x in bottoms.items():
        top = points[f"{name}_point"]
        up = top - [x, top[1], _feather_height(last, np.array(x))]
        planes[name] = (top, unit(np.cross([0.0, 1.0, 0.0], up)))
    return planes


def _tape(grid: Floats, point: Floats, normal: Floats) -> float:
    """Length of a tape round the section of a plane that cuts every column once."""
    signed = (grid - point) @ normal
    row = (signed >= 0.0).argmax(axis=0)
    column = np.arange(grid.shape[1])
    before, after = signed[row - 1, column], signed[row, column]
    part = (before / (before - after))[:, None]
    section = grid[row - 1, column] * (1.0 - part) + grid[row, column] * part
    first = unit(np.cross(normal, [0.0, 0.0, 1.0]))
    return float(ConvexHull(section @ np.stack([first, np.cross(normal, first)], axis=1)).area)


def _mesh(grid: Floats, height: float) -> trimesh.Trimesh:
    """The triangles of the grid below the cone's cut."""
    rows, columns = grid.shape[:2]
    corner = np.arange(rows * columns).reshape(rows, columns)
    # Diagonals towards the ridge on either side, so that none joins two points of the ridge at the folded toe.
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    inner = np.tile(np.arange(columns - 1) < columns // 2, rows - 1)[:, None]
    triangles = np.concatenate(
        [
            np.where(inner, np.stack([a, c, b], axis=1), np.stack([a, d, b], axis=1)),
            np.where(inner, np.stack([a, d, c], axis=1), np.stack([b, d, c], axis=1)),
        ]
    )
    vertices, triangles, _ = trimesh.intersections.slice_faces_plane(
        grid.reshape(-1, 3), triangles, plane_normal=[0.0, 0.0, -1.0], plane_origin=[0.0, 0.0, height]
    )
    vertices[np.abs(vertices[:, 2] - height) < 1e-9, 2] = height  # the cut's vertices, off the plane by round-off
    return tidy_mesh(vertices, triangles)


def _marks(
    last: ShoeLast, grid: Floats, mesh: trimesh.Trimesh, height: float
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """The landmarks, (3,) mm, and the lines, (m, 3) mm, of a right last."""
    middle = grid.shape[1] // 2
    highest = int(np.flatnonzero(_ridge(grid)[:, 2] > height)[-1])
    front = _up_to(np.vstack([grid[-1, :middle], _ridge(grid)[::-1]])[: -highest or None], height)[::-1]
    lines = {
        "feather": np.vstack([grid[:, 0], grid[-2::-1, -1]]),
        "cone_edge": _cone_edge(mesh, height),
        "back_line": _up_to(grid[0, : middle + 1], height),
        "front_line": front,
    }
    for name, (point, normal) in _girth_planes(last, grid).items():
        lines[f"{name}_line"] = _section(mesh, point, normal)
    _, stations = _rows(last.length)
    for percent, row in zip(STATIONS, stations, strict=True):
        lines[f"inner_{percent}"] = _up_to(grid[row, : middle + 1], height)
        lines[f"outer_{percent}"] = _up_to(grid[row, : middle - 1 : -1], height)
    landmarks = _points(last, grid) | {"cone_back": lines["back_line"][-1], "cone_front": front[0]}
    return {name: np.array(point) for name, point in landmarks.items()}, lines


def _up_to(line: Floats, height: float) -> Floats:
    """The part of a line from its start up to where it first reaches the height."""
    above = np.flatnonzero(line[:, 2] >= height)
    if len(above) == 0:
        return np.array(line)
    end = int(above[0])
    part = (height - line[end - 1, 2]) / (line[end, 2] - line[end - 1, 2])
    return np.vstack([line[:end], line[end - 1] + part * (line[end] - line[end - 1])])


def _cone_edge(mesh: trimesh.Trimesh, height: float) -> Floats:
    """The rim of the cut, from its hindmost vertex, the cone on its right."""
    rims = [mesh.vertices[loop] for loop in chains(boundary_edges(mesh.faces))]
    rim = next(points for points in rims if (points[:, 2] == height).all())[:-1]
    rim = np.roll(rim, -int(rim[:, 0].argmin()), axis=0)
    return np.vstack([rim, rim[:1]])


def _section(mesh: trimesh.Trimesh, point: Floats, normal: Floats) -> Floats:
    """Where a plane cuts the mesh from feather edge to feather edge, from the inner side to the outer."""
    path = mesh.section(plane_normal=normal, plane_origin=point)
    assert path is not None, "the planes of the girths cut the last"
    (line,) = (entity.discrete(path.vertices) for entity in path.entities)
    return np.array(line if line[0, 1] > line[-1, 1] else line[::-1])
