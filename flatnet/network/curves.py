"""Curves drawn densely from point to point become stretches, sampled once from node to node."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flatnet.geometry.polygon import arclengths
from flatnet.network.network import GeometryError
from flatnet.project.curve_specs import CurveSpec, OnLine

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Dense samples per edge length, from which a spline or a curve on the surface is measured and sampled.
DENSITY = 8
#: Relative excess of an edge over the edge length that is round-off.
ROUND_OFF = 1e-9
#: How often the number of edges is raised to meet edge length and chord tolerance.
MAX_REFINEMENTS = 40


@dataclass(frozen=True, eq=False)
class ControlPolygon:
    """The points that a curve is drawn through.

    Attributes
    ----------
    positions : (m + 1, 3) float, mm; of a closed curve the last is the first.
    nodes : (m + 1) node names; None at points that are no nodes.
    shift : how many points of the file's list stand before `positions[0]`, which was moved to a node; closed
        curves only.
    """

    positions: Floats
    nodes: tuple[str | None, ...]
    closed: bool
    shift: int = 0


@dataclass(frozen=True, eq=False)
class DrawnCurve:
    """A curve drawn densely, to be cut at its nodes and sampled.

    Attributes
    ----------
    control : what it is drawn through.
    points : (d, 3) float, mm; of a closed curve the last is the first.
    parameters : (d,) float, increasing.
    at : parameters -> points of the curve, (k, 3).
    control_index : (m + 1,) which of the points are those of `control`.
    nodes : index among the points and name of every node, in order; of a closed curve each once.
    corners : (c,) indices of points that stay vertices, although no stretch ends there.
    chord_tolerance : largest distance of an edge from the curve, mm.
    """

    control: ControlPolygon
    points: Floats
    parameters: Floats
    at: Callable[[Floats], Floats]
    control_index: Ints
    nodes: tuple[tuple[int, str], ...]
    corners: Ints
    chord_tolerance: float = np.inf

    @property
    def arclengths(self) -> Floats:
        """(d,) mm from its first point."""
        return arclengths(self.points)

    def cut(self, parameter: float, node: str, position: Floats) -> DrawnCurve:
        """The same curve with a node at a parameter, (3,) mm."""
        here = int(np.searchsorted(self.parameters, parameter))
        new = here == len(self.parameters) or self.parameters[here] != parameter
        points, parameters = self.points.copy(), self.parameters
        if new:
            points = np.insert(points, here, position, axis=0)
            parameters = np.insert(parameters, here, parameter)
        points[here] = position
        if self.control.closed and here in (0, len(points) - 1):  # its first point is its last
            points[0] = points[-1] = position
            here = 0
        nodes = [(i + (new and i >= here), name) for i, name in self.nodes]
        return replace(
            self,
            points=points,
            parameters=parameters,
            control_index=self.control_index + (new & (self.control_index >= here)),
            nodes=tuple(sorted([*nodes, (here, node)])),
            corners=self.corners + (new & (self.corners >= here)),
        )


@dataclass(frozen=True, eq=False)
class StretchSamples:
    """One stretch: (k + 1, 3) vertices in mm, and (k + 1,) arclengths from the curve's start.

    Of a closed curve that is cut elsewhere than at its start, they go on beyond its whole length.
    """

    start: str | None
    end: str | None
    vertices: Floats
    arclengths: Floats


@dataclass(frozen=True, eq=False)
class CurveSamples:
    """A sampled curve, stretch by stretch, with the arclength of its control points, (m + 1,) mm."""

    control: ControlPolygon
    control_arclengths: Floats
    stretches: tuple[StretchSamples, ...]


def control_polygon(
    curve: CurveSpec, places: Mapping[str, Floats], guides: Mapping[OnLine, Floats]
) -> ControlPolygon:
    """The points of a curve, its nodes and guides in their places; a closed one starts at a node if it has any."""
    entries: list[str | OnLine | Floats] = list(curve.points)
    if curve.start is not None:
        entries.insert(0, curve.start)
    closed = curve.closed or (curve.start is not None and curve.start == curve.end)
    if curve.end is not None and not closed:
        entries.append(curve.end)
    shift = 0
    if closed and entries:
        shift = next((i for i, entry in enumerate(entries) if isinstance(entry, str)), 0)
        entries = entries[shift:] + entries[:shift]
        entries.append(entries[0])

    def position(entry: str | OnLine | Floats) -> Floats:
        return guides[entry] if isinstance(entry, OnLine) else places[entry] if isinstance(entry, str) else entry

    positions = np.array([position(entry) for entry in entries], dtype=float)
    nodes = tuple(e if isinstance(e, str) else None for e in entries)
    return ControlPolygon(positions.reshape(-1, 3), nodes, closed, shift)


def sample_curve(curve: CurveSpec, drawn: DrawnCurve) -> CurveSamples:
    """Sample a drawn curve from node to node, so that its nodes and corners are vertices.

    Between them its vertices are even in arclength, its edges no longer than `curve.edge_length` and within
    the chord tolerance of it.

    Raises
    ------
    GeometryError
        The surface is too rough to be sampled.
    """
    arcs = drawn.arclengths
    last = len(drawn.points) - 1
    points, parameters, at, corners = drawn.points, drawn.parameters, drawn.at, drawn.corners
    ends: list[tuple[tuple[int, str | None], tuple[int, str | None]]] = list(pairwise(drawn.nodes))
    if drawn.control.closed:  # a second time round, for the stretch that passes its start
        period = parameters[-1] - parameters[0]
        points = np.vstack([points, points[1:]])
        parameters = np.concatenate([parameters, parameters[1:] + period])
        corners = np.concatenate([corners, corners + last])
        at = _periodic(drawn.at, drawn.parameters[0], period)
        if drawn.nodes:
            (first, name), end = drawn.nodes[0], drawn.nodes[-1]
            ends.append((end, (first + last, name)))
        else:
            ends = [((0, None), (last, None))]
    along = arclengths(points)
    stretches = []
    for (first, start), (final, end_name) in ends:
        stops = [first, *(int(c) for c in np.unique(corners) if first < c < final), final]
        fewest = 3 if start == end_name and len(stops) == 2 else 1
        parts = [
            _sample_evenly(curve, points[a : b + 1], parameters[a : b + 1], at, drawn.chord_tolerance, fewest)
            for a, b in pairwise(stops)
        ]
        vertices = np.vstack([parts[0][0][:1], *(vertices[1:] for vertices, _ in parts)])
        lengths = [part + along[a] for (_, part), a in zip(parts, stops)]
        stretches.append(
            StretchSamples(
                start, end_name, vertices, np.concatenate([lengths[0][:1], *(part[1:] for part in lengths)])
            )
        )
    return CurveSamples(drawn.control, arcs[drawn.control_index], tuple(stretches))


def _periodic(at: Callable[[Floats], Floats], start: float, period: float) -> Callable[[Floats], Floats]:
    return lambda t: at(start + (t - start) % period)


def _sample_evenly(
    curve: CurveSpec,
    dense: Floats,
    parameters: Floats,
    at: Callable[[Floats], Floats],
    chord_tolerance: float,
    fewest: int,
) -> tuple[Floats, Floats]:
    """Vertices even in arclength along a dense polyline, and their arclengths; as few as the bounds allow."""
    arcs = arclengths(dense)
    count = max(fewest, int(np.ceil(arcs[-1] / curve.edge_length * (1.0 - ROUND_OFF))))
    for _ in range(MAX_REFINEMENTS):
        along = np.linspace(0.0, arcs[-1], count + 1)
        if len(dense) == 2:  # straight: divided without the round-off of lengths
            inside = dense[0] + (np.arange(count) / count)[:, None] * (dense[1] - dense[0])
            return np.vstack([inside, dense[1]]), along
        at_vertices = np.interp(along, arcs, parameters)
        vertices = at(at_vertices)
        vertices[0], vertices[-1] = dense[0], dense[-1]
        longest = np.linalg.norm(np.diff(vertices, axis=0), axis=1).max()
        error = _chord_error(at, at_vertices, vertices) if np.isfinite(chord_tolerance) else 0.0
        too_long = longest / curve.edge_length * (1.0 - ROUND_OFF)
        too_far = np.sqrt(error / chord_tolerance)  # the error falls with the square of the edge
        if max(too_long, too_far) <= 1.0:
            return vertices, along
        count = max(count + 1, int(np.ceil(count * min(max(too_long, too_far), 2.0))))
    raise GeometryError(
        curve.mark,
        f"curve '{curve.name}' can't be sampled: with {count} edges the longest still is {longest:.3g} mm, "
        f"wanted {curve.edge_length:g} mm; the surface is rough there, or the curve runs far off it",
    )


def _chord_error(at: Callable[[Floats], Floats], at_vertices: Floats, vertices: Floats) -> float:
    """Largest distance of the curve from the edges that stand for it, measured between their ends."""
    fractions = np.arange(1, DENSITY) / DENSITY
    between = at_vertices[:-1, None] + fractions * np.diff(at_vertices)[:, None]
    offset = at(between.ravel()).reshape(*between.shape, 3) - vertices[:-1, None]
    chord = np.diff(vertices, axis=0)[:, None]
    part = np.sum(offset * chord, axis=2) / np.sum(chord * chord, axis=2)
    return float(np.linalg.norm(offset - np.clip(part, 0.0, 1.0)[:, :, None] * chord, axis=2).max())
