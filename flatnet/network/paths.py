"""What a curve can follow on the surface: a line of its form, a plane section, edges of its mesh."""

from __future__ import annotations

from itertools import pairwise

import networkx as nx
import numpy as np
import trimesh
from numpy.typing import NDArray

from flatnet.failure import spoken
from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.chains import boundary_edges, chains
from flatnet.geometry.polygon import arclengths
from flatnet.geometry.triangles import dot
from flatnet.network.curves import ROUND_OFF, ControlPolygon
from flatnet.network.network import GeometryError
from flatnet.project.curve_specs import CurveSpec, MeshEdges, NamedLine, PlaneSection
from flatnet.project.values import nearest

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A node may lie this far off the path that its curve follows, in edge lengths; the curve is then led through it.
OFF_PATH = 0.1
#: A section's normal may be turned by this much, rad, so that its plane goes through two nodes.
LARGEST_TURN = np.radians(30.0)
#: A vertex nearer to a plane than this, in diagonals of the mesh, lies on it.
ON_PLANE = 1e-9


def follow(
    curve: CurveSpec, control: ControlPolygon, surface: ReferenceSurface
) -> tuple[ControlPolygon, Floats, Ints]:
    """A curve along its path: its control polygon taken to the path, its points (k, 3), and which are control's.

    Of several paths (sections of two legs, boundary loops) it is the one nearest to the curve's points. Between
    two nodes of a closed path the curve takes the shorter way round, unless further points tell another.

    Raises
    ------
    GeometryError
        There is no such path, or a node lies off it, or its points stand in another order than on the path.
    """
    path = curve.path
    points = control.positions
    if isinstance(path, NamedLine):
        found, what = [_line(curve, path, surface)], f"line '{path.line}'"
    elif isinstance(path, PlaneSection):
        found, what = _sections(surface.mesh, *_plane(curve, path, control)), "the section"
        if not found:
            raise GeometryError(curve.mark, f"curve '{curve.name}': the plane of its section misses the surface")
        if len(points) == 0 and path.point is not None:
            points = path.point[None]
    else:
        assert path is not None, "only a curve with a path follows one"
        found, what = [_mesh_edges(curve, path, control, surface.mesh)], f"the {path.what} edges of the surface"
    way = min(found, key=lambda each: sum(_distance(point, each[:-1], each[1:]) for point in points))
    return _between(curve, control, way, what)


def _line(curve: CurveSpec, path: NamedLine, surface: ReferenceSurface) -> Floats:
    if path.line not in surface.lines:
        hint = nearest(path.line, surface.lines, "lines").replace("the file has", "the surface has")
        raise GeometryError(curve.mark, f"curve '{curve.name}': line: there is no line '{path.line}'; {hint}")
    return surface.lines[path.line].points


def _plane(curve: CurveSpec, path: PlaneSection, control: ControlPolygon) -> tuple[Floats, Floats]:
    """A point (3,) and the unit normal (3,) of a section's plane."""
    if path.point is not None and path.normal is not None:
        return path.point, path.normal
    start, end = control.positions[0], control.positions[-1]
    chord = end - start
    if path.normal is None:
        assert path.point is not None, "a section has a point or a normal"
        normal = np.cross(chord, path.point - start)
        area, size = np.linalg.norm(normal), np.linalg.norm(chord) * np.linalg.norm(path.point - start)
        if area <= 1e-3 * size:
            raise GeometryError(
                curve.mark,
                f"curve '{curve.name}': section: its point {spoken(path.point)} lies in line with 'from' and 'to', so "
                "that no one plane goes through the three; give 'normal' too, or another point",
            )
        return start, normal / area
    if np.linalg.norm(chord) == 0.0:  # round from a node to itself
        return start, path.normal
    along = chord / np.linalg.norm(chord)
    lean = float(along @ path.normal)
    if abs(lean) > np.sin(LARGEST_TURN):
        raise GeometryError(
            curve.mark,
            f"curve '{curve.name}': section: a plane through 'from' and 'to' is turned by "
            f"{np.degrees(np.arcsin(abs(lean))):.0f} degrees against 'normal' (at most "
            f"{np.degrees(LARGEST_TURN):.0f}); give a normal across the way from one to the other",
        )
    normal = path.normal - lean * along
    return start, normal / np.linalg.norm(normal)


def _sections(mesh: trimesh.Trimesh, point: Floats, normal: Floats) -> list[Floats]:
    """The cuts of a mesh with a plane, each (k, 3): anticlockwise round the inside, seen against the normal.

    A vertex on the plane counts as above it, so that a rim in the plane is its own section; where nothing lies
    below, as below it.
    """
    height = (np.asarray(mesh.vertices) - point) @ normal
    height[np.abs(height) <= ON_PLANE * mesh.scale] = 0.0
    for above in (height >= 0.0, height > 0.0):
        cut = np.asarray(mesh.edges_unique)
        crossing = above[cut[:, 0]] != above[cut[:, 1]]
        if crossing.any():
            break
    else:
        return []
    # In a triangle that is cut, two edges are: the section runs from one to the other.
    of_triangle = np.asarray(mesh.faces_unique_edges)
    is_cut = crossing[of_triangle]
    triangles = np.flatnonzero(is_cut.sum(axis=1) == 2)
    links = of_triangle[triangles][is_cut[triangles]].reshape(-1, 2)
    a, b = mesh.vertices[cut[:, 0]], mesh.vertices[cut[:, 1]]
    difference = np.where(crossing, height[cut[:, 0]] - height[cut[:, 1]], 1.0)
    at = a + (height[cut[:, 0]] / difference)[:, None] * (b - a)
    onward = np.cross(normal, mesh.face_normals[triangles])
    turned = dot(at[links[:, 1]] - at[links[:, 0]], onward) < 0.0
    links[turned] = links[turned][:, ::-1]
    forwards = {(int(i), int(j)) for i, j in links}
    sections = []
    for chain in chains(links):
        points = _without_repeats(at[chain])
        if len(points) < 2:  # the plane touches the surface in a vertex
            continue
        if chain[0] == chain[-1]:
            points[-1] = points[0]
        against = sum((i, j) not in forwards for i, j in pairwise(chain))
        sections.append(points[::-1] if 2 * against > len(chain) - 1 else points)
    return sections


def _without_repeats(points: Floats) -> Floats:
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return points[np.concatenate([[True], steps > 1e-12 * (steps.sum() + 1e-300)])]


def _mesh_edges(
    curve: CurveSpec, path: MeshEdges, control: ControlPolygon, mesh: trimesh.Trimesh
) -> Floats:
    """The chain nearest to a curve's points of the mesh's boundary, or of its edges whose faces meet at an angle.

    A boundary loop has the surface on its left. Where chains meet, the ways over them from point to point, joined,
    are the path.
    """
    if path.what == "boundary":
        edges = boundary_edges(np.asarray(mesh.faces))
        lacks = "the surface is closed, it has no boundary"
    else:
        edges = np.asarray(mesh.face_adjacency_edges)[mesh.face_adjacency_angles > path.angle]
        angle = np.degrees(path.angle)
        lacks = f"no two faces of the mesh meet at more than {angle:g} degrees; give along: {{feature: <fewer>}}"
    if len(edges) == 0:
        raise GeometryError(curve.mark, f"curve '{curve.name}': along: {lacks}")
    places = np.asarray(mesh.vertices)
    graph = nx.Graph()
    graph.add_edges_from(edges.tolist())
    parts = [edges[np.isin(edges[:, 0], list(part))] for part in nx.connected_components(graph)]
    stops = control.positions
    if len(stops) == 0 and len(parts) > 1:
        message = f"there are {len(parts)} chains of {path.what} edges; give a point near the one meant in 'points'"
        raise GeometryError(curve.mark, f"curve '{curve.name}': along: {message}")
    part = min(parts, key=lambda each: sum(_distance(stop, *places[each.T]) for stop in stops))
    found = chains(part)
    if len(found) == 1:
        return places[found[0]]
    if len(stops) < 2:
        raise GeometryError(
            curve.mark,
            f"curve '{curve.name}': along: the {path.what} edges branch, so that they make no one closed curve; give "
            "'from' and 'to', and points where the way is unclear, or another angle",
        )
    return _way_over(curve, part, stops, places)


def _way_over(curve: CurveSpec, edges: Ints, stops: Floats, places: Floats) -> Floats:
    """The shortest ways over edges from stop to stop, joined; each stop is taken to the nearest place on the edges."""
    graph = nx.Graph()
    at = {int(v): places[v] for v in np.unique(edges)}
    graph.add_edges_from(edges.tolist())
    for i, stop in enumerate(stops):
        pairs = list(graph.edges)
        starts = np.array([at[a] for a, _ in pairs])
        feet = _feet(stop, starts, np.array([at[b] for _, b in pairs]))
        k = int(np.linalg.norm(feet - stop, axis=1).argmin())
        a, b = pairs[k]
        graph.remove_edge(a, b)
        graph.add_edges_from([(a, -1 - i), (-1 - i, b)])
        at[-1 - i] = feet[k]
    for a, b in graph.edges:
        graph.edges[a, b]["length"] = float(np.linalg.norm(at[a] - at[b]))
    way = [-1]
    for i in range(1, len(stops)):
        try:
            way += nx.shortest_path(graph, -i, -1 - i, weight="length")[1:]
        except nx.NetworkXNoPath as error:
            raise GeometryError(
                curve.mark,
                f"curve '{curve.name}': along: no edges lead from {spoken(stops[i - 1])} to {spoken(stops[i])}",
            ) from error
    return _without_repeats(np.array([at[v] for v in way]))


def _feet(point: Floats, starts: Floats, ends: Floats) -> Floats:
    """The nearest point of every segment, (k, 3)."""
    chords = ends - starts
    squared = np.maximum(dot(chords, chords), 1e-300)
    return starts + np.clip(dot(point - starts, chords) / squared, 0.0, 1.0)[:, None] * chords


def _distance(point: Floats, starts: Floats, ends: Floats) -> float:
    """From the nearest of the segments, mm."""
    return float(np.linalg.norm(_feet(point, starts, ends) - point, axis=1).min())


def _between(
    curve: CurveSpec, control: ControlPolygon, path: Floats, what: str
) -> tuple[ControlPolygon, Floats, Ints]:
    """The part of a path that a curve follows, from its first point over the others to its last.

    Where nodes lie a little off the path, the curve leaves it by what lies between, linearly from node to node.
    """
    round_ = np.array_equal(path[0], path[-1])
    along = arclengths(path)
    total = along[-1]
    stops, landed = _project_stops(curve, control, path, along, what)
    if control.closed and not round_ and curve.start is not None:
        message = f"{what} is open, so that no way leads round to '{curve.start}' again"
        raise GeometryError(curve.mark, f"curve '{curve.name}': {message}")
    if len(stops) == 0 or (control.closed and not round_):
        # All of it. Between the ends of an open path come the points.
        stops = np.concatenate([[0.0], stops[:-1], [total]])
        landed = np.vstack([path[:1], landed[:-1], path[-1:]])
        positions = np.vstack([path[:1], control.positions[:-1], path[-1:]])
        control = ControlPolygon(positions, (None, *control.nodes[:-1], None), round_)
    elif round_:
        path, along, stops = _way_round(path, along, stops, control.closed)
    elif stops[0] > stops[-1]:
        path, along, stops = path[::-1], total - along[::-1], total - stops
    wrong = np.diff(stops) <= 0.0
    if wrong.any() or stops[-1] - stops[0] > total * (1.0 + ROUND_OFF):
        i = int(wrong.argmax())
        raise GeometryError(
            curve.mark,
            f"curve '{curve.name}': {what} does not pass its points in their order: after {spoken(landed[i])} it "
            f"would have to turn back to {spoken(landed[i + 1])}; change their order, or divide the curve in two",
        )
    apart = ROUND_OFF * total
    clear = np.abs(along[:, None] - stops).min(axis=1) > apart
    knots = np.sort(np.concatenate([stops, along[clear & (along > stops[0]) & (along < stops[-1])]]))
    points = np.stack([np.interp(knots, along, column) for column in path.T], axis=1)
    index = np.searchsorted(knots, stops)
    held = [i for i, node in enumerate(control.nodes) if node is not None]
    if held:
        off = control.positions[held] - landed[held]
        points += np.stack([np.interp(knots, stops[held], column) for column in off.T], axis=1)
    if control.closed:
        points[-1] = points[0]
    positions = points[index].copy()
    for i in held:
        positions[i] = control.positions[i]
    return ControlPolygon(positions, control.nodes, control.closed, control.shift), points, index


def _project_stops(
    curve: CurveSpec, control: ControlPolygon, path: Floats, along: Floats, what: str
) -> tuple[Floats, Floats]:
    """Arclengths of the nearest places on the path of a curve's points, (m,), and these places, (m, 3)."""
    stops, landed = [], []
    for point, node in zip(control.positions, control.nodes):
        feet = _feet(point, path[:-1], path[1:])
        distances = np.linalg.norm(feet - point, axis=1)
        k = int(distances.argmin())
        if node is not None and distances[k] > OFF_PATH * curve.edge_length:
            raise GeometryError(
                curve.mark,
                f"curve '{curve.name}': node '{node}' lies {distances[k]:.2f} mm off {what}, more than {OFF_PATH:g} "
                f"edge lengths of {curve.edge_length:g} mm; the nearest place on it is {spoken(feet[k])}",
            )
        stops.append(along[k] + float(np.linalg.norm(feet[k] - path[k])))
        landed.append(feet[k])
    return np.array(stops), np.array(landed).reshape(-1, 3)


def _way_round(
    path: Floats, along: Floats, stops: Floats, closed: bool
) -> tuple[Floats, Floats, Floats]:
    """A closed path twice round from its start, in the direction that passes the stops in their order.

    Stops are then increasing. If they stand in order both ways round, it is the shorter way between the first and
    the last of an open curve, and the path's own direction for a closed one.
    """
    total = along[-1]

    def travelled(sense: float) -> Floats:
        steps = (sense * np.diff(stops)) % total
        if closed and len(stops) == 2:  # from a node round to itself
            steps = np.array([total])
        return np.concatenate([[0.0], np.cumsum(steps)])

    forwards, backwards = travelled(1.0), travelled(-1.0)
    turn_back = backwards[-1] < forwards[-1] * (1.0 - 1e-9)
    start = stops[0]
    if turn_back:
        path, along, start = path[::-1], total - along[::-1], total - start
    twice = np.vstack([path, path[1:]])
    return twice, np.concatenate([along, along[1:] + total]), start + (backwards if turn_back else forwards)
