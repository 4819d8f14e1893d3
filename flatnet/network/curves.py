"""Sample every curve once, from node to node: polyline, spline, or either projected onto the surface."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from flatnet.forms.surface import ReferenceSurface
from flatnet.network.network import GeometryError
from flatnet.project.model import CurveSpec, NodeSpec

Floats = NDArray[np.float64]
#: Vertices of a stretch, (k + 1, 3) mm, and their arclengths from the curve's start, (k + 1,) mm.
_Piece = tuple[Floats, Floats]

#: Dense samples per edge length, from which a spline or a projected curve is measured and sampled.
DENSITY = 8
#: A projected curve jumps where points that were this many dense samples apart, half an edge length at most ...
JUMP_SAMPLES = DENSITY // 2
#: ... land more than this many edge lengths apart.
JUMP_EDGES = 2.0
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
class StretchSamples:
    """One stretch: (k + 1, 3) vertices in mm, and (k + 1,) arclengths from the curve's start."""

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


def place_nodes(
    nodes: Mapping[str, NodeSpec], curves: Mapping[str, CurveSpec], surface: ReferenceSurface | None
) -> dict[str, Floats]:
    """The one position of every node, mm; on the surface where the node or a curve through it says so."""
    projected = {name for name, node in nodes.items() if node.on_surface}
    for curve in curves.values():
        if curve.on_surface:
            projected.update(curve.nodes)
    places = {name: np.array(node.position, dtype=float) for name, node in nodes.items()}
    on_surface = [name for name in nodes if name in projected]
    if on_surface:
        assert surface is not None, "a project whose nodes lie on a surface has one"
        feet, _ = surface.nearest(np.array([places[name] for name in on_surface]))
        places |= zip(on_surface, np.array(feet), strict=True)
    for position in places.values():
        position.setflags(write=False)
    return places


def control_polygon(curve: CurveSpec, places: Mapping[str, Floats]) -> ControlPolygon:
    """The points of a curve, its nodes in their places; a closed one starts at a node if it has any."""
    entries: list[str | Floats] = list(curve.points)
    if curve.start is not None:
        entries.insert(0, curve.start)
    closed = curve.closed or (curve.start is not None and curve.start == curve.end)
    if curve.end is not None and not closed:
        entries.append(curve.end)
    shift = 0
    if closed:
        shift = next((i for i, entry in enumerate(entries) if isinstance(entry, str)), 0)
        entries = entries[shift:] + entries[:shift]
        entries.append(entries[0])
    positions = np.array([places[e] if isinstance(e, str) else e for e in entries], dtype=float)
    chords = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    for i in np.flatnonzero(chords <= ROUND_OFF * chords.sum()):
        raise GeometryError(
            curve.mark,
            f"curve '{curve.name}': point {i + 1} and the next, both at {_place(positions[i])}, coincide; "
            "leave one of them out",
        )
    nodes = tuple(e if isinstance(e, str) else None for e in entries)
    return ControlPolygon(positions, nodes, closed, shift)


def sample_curve(
    curve: CurveSpec,
    places: Mapping[str, Floats],
    surface: ReferenceSurface | None,
    chord_tolerance: float,
) -> CurveSamples:
    """Sample a curve from node to node, so that its nodes are vertices.

    A polyline keeps every point and divides only segments longer than the edge length. A spline is cubic,
    interpolating, parametrised by chord length, natural or (closed) periodic, and sampled evenly by arclength
    with edges no longer than `curve.edge_length` that stay within `chord_tolerance` of it. On the surface
    either is drawn densely, taken to the nearest points of the surface, sampled there evenly by arclength,
    and the samples are taken to the nearest points again.

    Raises
    ------
    GeometryError
        Two points coincide; the projection jumps.
    """
    control = control_polygon(curve, places)
    arcs, pieces = (
        _sample_polyline(control, curve.edge_length)
        if curve.kind == "polyline" and not curve.on_surface
        else _sample_smooth(curve, control, surface, chord_tolerance)
    )
    stretches = [
        StretchSamples(control.nodes[first], control.nodes[last], vertices, along)
        for (first, last), (vertices, along) in zip(pairwise(_cuts(control)), pieces, strict=True)
    ]
    return CurveSamples(control, arcs, tuple(stretches))


def _cuts(control: ControlPolygon) -> list[int]:
    """The control points where one stretch ends and the next begins, both ends of the curve included."""
    last = len(control.nodes) - 1
    return [i for i, node in enumerate(control.nodes) if node is not None or i in (0, last)]


def _sample_polyline(control: ControlPolygon, edge_length: float) -> tuple[Floats, list[_Piece]]:
    """Arclengths of the points, and every stretch's vertices with theirs; long segments equally divided."""
    points = control.positions
    arcs = _arclengths(points)
    counts = np.maximum(np.ceil(np.diff(arcs) / edge_length * (1.0 - ROUND_OFF)).astype(int), 1)
    pieces = []
    for first, last in pairwise(_cuts(control)):
        index = np.repeat(np.arange(first, last), counts[first:last])
        fraction = np.concatenate([np.arange(count) / count for count in counts[first:last]])
        vertices = points[index] + fraction[:, None] * (points[index + 1] - points[index])
        along = arcs[index] + fraction * (arcs[index + 1] - arcs[index])
        pieces.append((np.vstack([vertices, points[last]]), np.append(along, arcs[last])))
    return arcs, pieces


def _sample_smooth(
    curve: CurveSpec, control: ControlPolygon, surface: ReferenceSurface | None, chord_tolerance: float
) -> tuple[Floats, list[_Piece]]:
    """As `_sample_polyline`, for a spline, and for what is projected onto the surface."""
    knots = _arclengths(control.positions)
    at = _polyline(control, knots) if curve.kind == "polyline" else _spline(control, knots)
    parameters, dense_index = _dense_parameters(knots, curve.edge_length / DENSITY)
    dense = at(parameters)
    dense[dense_index] = control.positions
    tolerance = chord_tolerance
    if curve.on_surface:
        assert surface is not None, "a project whose curves lie on a surface has one"
        dense = _project(curve, control, dense_index, dense, surface)
        at = _on_surface(surface, dense, parameters)
        tolerance = np.inf  # a projected curve is sampled by edge length alone

    arcs = _arclengths(dense)
    pieces = []
    cuts = _cuts(control)
    fewest = 3 if control.closed and len(cuts) == 2 else 1
    for first, last in pairwise(cuts):
        part = slice(dense_index[first], dense_index[last] + 1)
        vertices, along = _sample_evenly(curve, dense[part], parameters[part], at, tolerance, fewest)
        pieces.append((vertices, arcs[dense_index[first]] + along))
    return arcs[dense_index], pieces


def _arclengths(points: Floats) -> Floats:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _polyline(control: ControlPolygon, knots: Floats) -> Callable[[Floats], Floats]:
    return lambda t: np.stack([np.interp(t, knots, column) for column in control.positions.T], axis=1)


def _spline(control: ControlPolygon, knots: Floats) -> Callable[[Floats], Floats]:
    return CubicSpline(knots, control.positions, bc_type="periodic" if control.closed else "natural")


def _dense_parameters(knots: Floats, spacing: float) -> tuple[Floats, NDArray[np.int64]]:
    """Parameters at most `spacing` apart, at least `DENSITY` a segment, and which of them are the knots."""
    counts = np.maximum(np.ceil(np.diff(knots) / spacing).astype(int), DENSITY)
    inside = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(knots[:-1], knots[1:], counts)]
    return np.append(np.concatenate(inside), knots[-1]), np.concatenate([[0], np.cumsum(counts)])


def _project(
    curve: CurveSpec,
    control: ControlPolygon,
    dense_index: NDArray[np.int64],
    dense: Floats,
    surface: ReferenceSurface,
) -> Floats:
    """The nearest surface points of a densely sampled curve; nodes stay where they are.

    Raises `GeometryError` where the projection jumps: a chord through a body lands on one side of it, then
    on the other.
    """
    landed = np.array(surface.nearest(dense)[0])
    for i, node in zip(dense_index, control.nodes):
        if node is not None:
            landed[i] = dense[i]
    if control.closed:
        landed[-1] = landed[0]
    jumps = np.linalg.norm(landed[JUMP_SAMPLES:] - landed[:-JUMP_SAMPLES], axis=1)
    worst = int(jumps.argmax())
    if jumps[worst] > JUMP_EDGES * curve.edge_length:
        along = _arclengths(dense)[worst]
        raise GeometryError(
            curve.mark,
            f"curve '{curve.name}': its projection onto the surface jumps by {jumps[worst]:.1f} mm, {along:.1f} mm "
            f"along the curve as drawn, from {_place(landed[worst])} to {_place(landed[worst + JUMP_SAMPLES])} "
            f"(more than {JUMP_EDGES:g} edge lengths of {curve.edge_length:g} mm): the curve runs through the inside "
            "or far off; add points nearer to the surface",
        )
    return landed


def _on_surface(surface: ReferenceSurface, dense: Floats, parameters: Floats) -> Callable[[Floats], Floats]:
    def at(t: Floats) -> Floats:
        between = np.stack([np.interp(t, parameters, column) for column in dense.T], axis=1)
        return np.array(surface.nearest(between)[0])

    return at


def _sample_evenly(
    curve: CurveSpec,
    dense: Floats,
    parameters: Floats,
    at: Callable[[Floats], Floats],
    chord_tolerance: float,
    fewest: int,
) -> tuple[Floats, Floats]:
    """Vertices even in arclength along a dense polyline, and their arclengths; as few as the bounds allow."""
    arcs = _arclengths(dense)
    count = max(fewest, int(np.ceil(arcs[-1] / curve.edge_length * (1.0 - ROUND_OFF))))
    for _ in range(MAX_REFINEMENTS):
        along = np.linspace(0.0, arcs[-1], count + 1)
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


def _place(point: Floats) -> str:
    return f"({point[0]:.1f}, {point[1]:.1f}, {point[2]:.1f})"
