"""Draw every curve densely: polyline, spline, either projected onto the surface, geodesic, fair, or along a path."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from flatnet.failure import spoken
from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.polygon import arclengths
from flatnet.network.curves import DENSITY, ROUND_OFF, ControlPolygon, DrawnCurve, control_polygon
from flatnet.network.fair_curves import relaxed
from flatnet.network.geodesics import NoWayError, geodesics
from flatnet.network.network import GeometryError
from flatnet.network.paths import follow
from flatnet.network.places import place_guides
from flatnet.project.curve_specs import CurveSpec

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A path that turns by more than this, rad, from half an edge length before a point to half of one after it, has a
#: corner there, which stays a vertex ...
CORNER = np.radians(45.0)
#: ... unless a node or a sharper corner is nearer than this, in edge lengths.
CORNERS_APART = 0.5
#: A projected curve jumps where points that were this many dense samples apart, half an edge length at most ...
JUMP_SAMPLES = DENSITY // 2
#: ... land more than this many edge lengths apart.
JUMP_EDGES = 2.0


def draw_curve(
    curve: CurveSpec, places: Mapping[str, Floats], surface: ReferenceSurface | None, chord_tolerance: float
) -> DrawnCurve:
    """Draw a curve through its points and nodes.

    A polyline keeps every point. A spline is cubic, interpolating, parametrised by chord length, natural or
    (closed) periodic. On the surface either is drawn densely and taken to the nearest points of the surface. A
    geodesic is the straightest way on the surface from point to point, a fair curve bends least on it; both
    keep to the surface from the start, and so does what follows a path.

    Raises
    ------
    GeometryError
        Two points coincide; the projection jumps; there is no way on the surface; the path is not there, or not
        where the nodes are.
    """
    control = control_polygon(curve, places, place_guides(curve, surface))
    if curve.path is not None:
        assert surface is not None, "a project whose curves lie on a surface has one"
        followed, points, index = follow(curve, control, surface)
        return _along_surface(curve, followed, points, index, surface)
    _refuse_repeats(curve, control)
    if not curve.on_surface:
        knots = arclengths(control.positions)
        every = np.arange(len(knots))
        if curve.kind == "polyline":
            return _drawn(control, control.positions, knots, _polyline(control.positions, knots), every, every)
        at: Callable[[Floats], Floats] = _spline(control, knots)
        parameters, index = _dense_parameters(knots, curve.edge_length / DENSITY)
        dense = at(parameters)
        dense[index] = control.positions
        return _drawn(control, dense, parameters, at, index, every[:0], chord_tolerance)
    assert surface is not None, "a project whose curves lie on a surface has one"
    if curve.kind in ("geodesic", "fair"):
        legs = _geodesic_legs(curve, control, surface)
        if curve.kind == "geodesic":
            points = np.vstack([legs[0][:1], *(leg[1:] for leg in legs)])
            index = np.concatenate([[0], np.cumsum([len(leg) - 1 for leg in legs])])
            on_surface = ControlPolygon(points[index], control.nodes, control.closed, control.shift)
            return _along_surface(curve, on_surface, points, index, surface, corners=index)
        through, own = relaxed(legs, control.closed, curve.edge_length, surface)
        nodes: list[str | None] = [None] * len(through)
        for i, node in zip(own, control.nodes):
            nodes[i] = node
        fine = _projected(curve, ControlPolygon(through, tuple(nodes), control.closed), "spline", surface)
        on_surface = ControlPolygon(through[own], control.nodes, control.closed, control.shift)
        return _drawn(on_surface, fine.points, fine.parameters, fine.at, fine.control_index[own], fine.corners)
    return _projected(curve, control, curve.kind, surface)


def _refuse_repeats(curve: CurveSpec, control: ControlPolygon) -> None:
    chords = np.linalg.norm(np.diff(control.positions, axis=0), axis=1)
    for i in np.flatnonzero(chords <= ROUND_OFF * chords.sum()):
        raise GeometryError(
            curve.mark,
            f"degenerate_curve: curve '{curve.name}': point {i + 1} and the next, both at "
            f"{spoken(control.positions[i])}, coincide; leave one of them out",
        )


def _drawn(
    control: ControlPolygon,
    points: Floats,
    parameters: Floats,
    at: Callable[[Floats], Floats],
    control_index: Ints,
    corners: Ints,
    chord_tolerance: float = np.inf,
) -> DrawnCurve:
    """The drawn curve, cut at the nodes of its control polygon."""
    named = list(zip(control_index.tolist(), control.nodes))[: -1 if control.closed else None]
    nodes = tuple((i, node) for i, node in named if node is not None)
    return DrawnCurve(control, points, parameters, at, control_index, nodes, corners, chord_tolerance)


def _polyline(positions: Floats, knots: Floats) -> Callable[[Floats], Floats]:
    return lambda t: np.stack([np.interp(t, knots, column) for column in positions.T], axis=1)


def _spline(control: ControlPolygon, knots: Floats) -> Callable[[Floats], Floats]:
    return CubicSpline(knots, control.positions, bc_type="periodic" if control.closed else "natural")


def _dense_parameters(knots: Floats, spacing: float, fewest: int = DENSITY) -> tuple[Floats, Ints]:
    """Parameters at most `spacing` apart, at least `fewest` a segment, and which of them are the knots."""
    counts = np.maximum(np.ceil(np.diff(knots) / spacing).astype(int), fewest)
    inside = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(knots[:-1], knots[1:], counts)]
    return np.append(np.concatenate(inside), knots[-1]), np.concatenate([[0], np.cumsum(counts)])


def _projected(
    curve: CurveSpec, control: ControlPolygon, kind: str, surface: ReferenceSurface
) -> DrawnCurve:
    """A polyline or spline, taken to the nearest points of the surface; its nodes stay where they are."""
    knots = arclengths(control.positions)
    at = _polyline(control.positions, knots) if kind == "polyline" else _spline(control, knots)
    parameters, index = _dense_parameters(knots, curve.edge_length / DENSITY)
    dense = at(parameters)
    dense[index] = control.positions
    landed = _land(curve, control, index, dense, surface)
    return _drawn(control, landed, parameters, _on_surface(surface, landed, parameters), index, index[:0])


def _land(
    curve: CurveSpec, control: ControlPolygon, index: Ints, dense: Floats, surface: ReferenceSurface
) -> Floats:
    """The nearest surface points of a densely sampled curve; nodes stay where they are.

    Raises `GeometryError` where the projection jumps: a chord through a body lands on one side of it, then
    on the other.
    """
    landed = np.array(surface.nearest(dense)[0])
    for i, node in zip(index, control.nodes):
        if node is not None:
            landed[i] = dense[i]
    if control.closed:
        landed[-1] = landed[0]
    jumps = np.linalg.norm(landed[JUMP_SAMPLES:] - landed[:-JUMP_SAMPLES], axis=1)
    worst = int(jumps.argmax())
    if jumps[worst] > JUMP_EDGES * curve.edge_length:
        along = arclengths(dense)[worst]
        raise GeometryError(
            curve.mark,
            f"curve '{curve.name}': its projection onto the surface jumps by {jumps[worst]:.1f} mm, {along:.1f} mm "
            f"along the curve as drawn, from {spoken(landed[worst])} to {spoken(landed[worst + JUMP_SAMPLES])} "
            f"(more than {JUMP_EDGES:g} edge lengths of {curve.edge_length:g} mm): the curve runs through the inside "
            "or far off; add points nearer to the surface",
        )
    return landed


def _on_surface(surface: ReferenceSurface, dense: Floats, parameters: Floats) -> Callable[[Floats], Floats]:
    between = _polyline(dense, parameters)
    return lambda t: np.array(surface.nearest(between(t))[0])


def _geodesic_legs(
    curve: CurveSpec, control: ControlPolygon, surface: ReferenceSurface
) -> list[Floats]:
    """The straightest ways from point to point; each starts and ends at the same points as its neighbours."""
    try:
        legs = geodesics(surface.mesh, control.positions)
    except NoWayError as error:
        raise GeometryError(curve.mark, f"curve '{curve.name}': {error}") from error
    for i, node in enumerate(control.nodes):  # to the last bit where the node is
        if node is not None:
            if i > 0:
                legs[i - 1][-1] = control.positions[i]
            if i < len(legs):
                legs[i][0] = control.positions[i]
    return legs


def _along_surface(
    curve: CurveSpec,
    control: ControlPolygon,
    points: Floats,
    index: Ints,
    surface: ReferenceSurface,
    corners: Ints | None = None,
) -> DrawnCurve:
    """A curve that is a polyline on the surface already, with points dense enough to be measured.

    `index` : which of `points` are those of `control`; `corners` : which stay vertices, else where it turns sharply.
    """
    knots = arclengths(points)
    parameters, kept = _dense_parameters(knots, curve.edge_length / DENSITY, fewest=1)
    dense = np.array(surface.nearest(_polyline(points, knots)(parameters))[0])
    for i, position, node in zip(kept[index], control.positions, control.nodes):
        if node is not None:
            dense[i] = position
    if control.closed:
        dense[-1] = dense[0]
    at = _on_surface(surface, dense, parameters)
    sharp = _corners(dense, kept, kept[index], control, curve.edge_length) if corners is None else kept[corners]
    return _drawn(control, dense, parameters, at, kept[index], sharp)


def _corners(
    dense: Floats, candidates: Ints, of_control: Ints, control: ControlPolygon, edge_length: float
) -> Ints:
    """Which of the candidates among the points of a curve are corners, in order."""
    arcs = arclengths(dense)
    total = arcs[-1]
    at = arcs[candidates]

    def beside(distance: float) -> Floats:
        where = (at + distance) % total if control.closed else np.clip(at + distance, 0.0, total)
        return np.stack([np.interp(where, arcs, column) for column in dense.T], axis=1)

    before, after = dense[candidates] - beside(-edge_length / 2), beside(edge_length / 2) - dense[candidates]
    turns = np.arctan2(np.linalg.norm(np.cross(before, after), axis=1), np.einsum("ij,ij->i", before, after))
    taken = [float(arcs[i]) for i, node in zip(of_control, control.nodes) if node is not None]
    taken += [] if control.closed else [0.0, float(total)]
    found = []
    for k in np.argsort(-turns, kind="stable"):
        apart = np.abs(np.array(taken) - at[k])
        apart = np.minimum(apart, total - apart) if control.closed else apart
        if turns[k] > CORNER and apart.min(initial=np.inf) >= CORNERS_APART * edge_length:
            taken.append(float(at[k]))
            found.append(int(candidates[k]))
    return np.array(sorted(found), dtype=np.int64)
