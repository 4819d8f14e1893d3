"""Where drawn curves touch: common points, ends near ends, ends near curves, crossings -> groups that are one node."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flatnet.geometry.polygon import polyline_length
from flatnet.geometry.triangles import dot
from flatnet.project.drawings.file_curve import FileCurve, Floats

Ints = NDArray[np.int64]

#: A place on a curve: its number, and vertex index + fraction of the segment behind it.
Contact = tuple[int, float]

#: Two segments cross where the sine of their angle is at least this; flatter ones run along each other.
FLATTEST_CROSSING = 0.1
#: A curve comes back to its own end where it has run this many tolerances in between.
COMES_BACK = 4.0


@dataclass(frozen=True)
class Crossing:
    """Two curves' inner points nearest to each other, `gap` mm apart."""

    first: Contact
    second: Contact
    gap: float
    place: Floats


class Segments:
    """All segments of all curves, to be searched by distance."""

    def __init__(self, curves: Sequence[FileCurve]) -> None:
        self.start = np.concatenate([curve.points[:-1] for curve in curves])
        self.end = np.concatenate([curve.points[1:] for curve in curves])
        self.curve = np.repeat(np.arange(len(curves)), [len(curve.points) - 1 for curve in curves])
        self.index = np.concatenate([np.arange(len(curve.points) - 1) for curve in curves])
        low, high = np.minimum(self.start, self.end), np.maximum(self.start, self.end)
        self._tree = shapely.STRtree(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))

    def feet(self, point: Floats, distance: float) -> list[Contact]:
        """The places of segments within a distance of a point, the nearest first."""
        near = np.sort(self._tree.query(shapely.Point(point).buffer(distance, quad_segs=2).envelope))
        chord = self.end[near] - self.start[near]
        fraction = np.clip(dot(point - self.start[near], chord) / dot(chord, chord), 0.0, 1.0)
        away = np.linalg.norm(self.start[near] + fraction[:, None] * chord - point, axis=1)
        order = [i for i in np.argsort(away, kind="stable") if away[i] <= distance]
        return [(int(self.curve[near[i]]), float(self.index[near[i]] + fraction[i])) for i in order]

    def nearest_other(self, point: Floats, own: int) -> tuple[int, float] | None:
        """The curve nearest to a point but for one, and its distance."""
        others = np.flatnonzero(self.curve != own)
        if not len(others):
            return None
        chord = self.end[others] - self.start[others]
        fraction = np.clip(dot(point - self.start[others], chord) / dot(chord, chord), 0.0, 1.0)
        away = np.linalg.norm(self.start[others] + fraction[:, None] * chord - point, axis=1)
        nearest = int(away.argmin())
        return int(self.curve[others[nearest]]), float(away[nearest])

    def crossings(self, distance: float) -> Iterator[Crossing]:
        """Pairs of segments, no neighbours on a curve, that pass each other within a distance."""
        low, high = np.minimum(self.start, self.end) - distance, np.maximum(self.start, self.end) + distance
        i, j = self._tree.query(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))
        apart = (i < j) & (low[i, 2] <= high[j, 2]) & (low[j, 2] <= high[i, 2])
        apart &= (self.curve[i] != self.curve[j]) | (np.abs(self.index[i] - self.index[j]) > 1)
        i, j = i[apart], j[apart]
        order = np.lexsort((j, i))
        i, j = i[order], j[order]
        s, t, crossing = _closest(self.start[i], self.end[i], self.start[j], self.end[j])
        a = self.start[i] + s[:, None] * (self.end[i] - self.start[i])
        b = self.start[j] + t[:, None] * (self.end[j] - self.start[j])
        gap = np.linalg.norm(a - b, axis=1)
        for k in np.flatnonzero(crossing & (gap <= distance)):
            first = int(self.curve[i[k]]), float(self.index[i[k]] + s[k])
            second = int(self.curve[j[k]]), float(self.index[j[k]] + t[k])
            yield Crossing(first, second, float(gap[k]), 0.5 * (a[k] + b[k]))


def _closest(a: Floats, b: Floats, c: Floats, d: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Fractions of the lines ab and cd at their nearest points, and whether these lie in both segments."""
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = dot(u, u), dot(u, v), dot(v, v)
    determinant = uu * vv - uv**2
    crossing = determinant > FLATTEST_CROSSING**2 * uu * vv
    safe = np.where(crossing, determinant, 1.0)
    s = (uv * dot(v, w) - vv * dot(u, w)) / safe
    t = (uu * dot(v, w) - uv * dot(u, w)) / safe
    inside = (s >= -1e-9) & (s <= 1 + 1e-9) & (t >= -1e-9) & (t <= 1 + 1e-9)
    return np.clip(s, 0.0, 1.0), np.clip(t, 0.0, 1.0), crossing & inside


class Joints:
    """Contacts of curves, those that are to be one node in one group.

    Parameters
    ----------
    curves : in mm.
    same : points nearer than this, mm, are the same point.
    """

    def __init__(self, curves: Sequence[FileCurve], same: float) -> None:
        self.curves = curves
        self.segments = Segments(curves)
        self.same = same
        self._group: dict[Contact, Contact] = {}
        for i, curve in enumerate(curves):
            if not curve.closed:
                self._find((i, 0.0))
                self._find((i, len(curve.points) - 1.0))
        self._share_points()

    def position(self, contact: Contact) -> Floats:
        curve, at = contact
        points = self.curves[curve].points
        i = min(int(at), len(points) - 2)
        return points[i] + (at - i) * (points[i + 1] - points[i])

    def is_end(self, contact: Contact) -> bool:
        curve = self.curves[contact[0]]
        return not curve.closed and contact[1] in (0.0, len(curve.points) - 1.0)

    def groups(self) -> list[list[Contact]]:
        """The contacts of every node, in the order of the curves."""
        found: dict[Contact, list[Contact]] = {}
        for contact in sorted(self._group):
            found.setdefault(self._find(contact), []).append(contact)
        return list(found.values())

    def place(self, group: Sequence[Contact]) -> Floats:
        """Where the node of a group lies: on the curves that pass, else amid the ends that meet."""
        passing = [contact for contact in group if not self.is_end(contact)]
        return np.mean([self.position(contact) for contact in passing or group], axis=0)

    def snap_ends(self, distance: float) -> None:
        """Ends that lie within a distance of each other, or of a point that curves share, are one node."""
        contacts = sorted(self._group)
        tree = cKDTree([self.position(contact) for contact in contacts])
        for i, j in sorted(tree.query_pairs(distance)):
            a, b = contacts[i], contacts[j]
            if (self.is_end(a) or self.is_end(b)) and not self._is_short(a, b, distance):
                self._join(a, b)

    def snap_onto(self, distance: float) -> None:
        """An end that lies within a distance of a curve is a node of it."""
        for group in self.groups():
            ends = [contact for contact in group if self.is_end(contact)]
            if not ends:
                continue
            place = self.place(group)
            met: set[int] = set()
            for contact in self.segments.feet(place, distance):
                own = [other for other in group if other[0] == contact[0]]
                foot = self._at_vertex(contact, place, distance)
                if contact[0] not in met and not any(self._is_short(other, foot, distance) for other in own):
                    met.add(contact[0])
                    self._join(ends[0], foot)

    def crossings(self, distance: float) -> list[Crossing]:
        """Where curves pass each other within a distance and have no node in common there."""
        found: list[Crossing] = []
        groups = self.groups()
        meet = [{curve for curve, _ in group} for group in groups]
        tree = cKDTree(np.array([self.place(group) for group in groups]).reshape(-1, 3))
        reach = max(COMES_BACK * distance, self.same)
        for crossing in self.segments.crossings(max(distance, self.same)):
            pair = {crossing.first[0], crossing.second[0]}
            known = any(pair <= meet[i] for i in tree.query_ball_point(crossing.place, reach))
            if not known and not any(
                pair == {other.first[0], other.second[0]} and np.linalg.norm(crossing.place - other.place) <= reach
                for other in found
            ):
                found.append(crossing)
        return found

    def join_crossing(self, crossing: Crossing) -> None:
        first, second = (
            self._at_vertex(contact, crossing.place, self.same) for contact in (crossing.first, crossing.second)
        )
        self._join(first, second)

    def _share_points(self) -> None:
        """Points that curves have in common are nodes of all of them."""
        places = [
            (i, float(k)) for i, c in enumerate(self.curves) for k in range(len(c.points) - (1 if c.closed else 0))
        ]
        tree = cKDTree([self.curves[i].points[int(k)] for i, k in places])
        for i, j in sorted(tree.query_pairs(self.same)):
            self._join(places[i], places[j])

    def _at_vertex(self, contact: Contact, place: Floats, distance: float) -> Contact:
        """The curve's vertex next to a contact, if it too lies within a distance of a place; else the contact."""
        curve, at = contact
        points = self.curves[curve].points
        vertex = round(at)
        if np.linalg.norm(points[vertex] - place) > distance and abs(at - vertex) > 1e-9:
            return contact
        return (curve, 0.0) if self.curves[curve].closed and vertex == len(points) - 1 else (curve, float(vertex))

    def _is_short(self, a: Contact, b: Contact, distance: float) -> bool:
        """Whether two contacts lie on one curve with little of it in between: joined, it would vanish there."""
        if a[0] != b[0]:
            return False
        first, last = sorted((a[1], b[1]))
        points = self.curves[a[0]].points
        inner = points[int(np.floor(first)) + 1 : int(np.ceil(last))]
        way = np.concatenate([[self.position((a[0], first))], inner, [self.position((a[0], last))]])
        return polyline_length(way) <= COMES_BACK * distance

    def _find(self, contact: Contact) -> Contact:
        parent = self._group.setdefault(contact, contact)
        while parent != self._group[parent]:
            parent = self._group[parent]
        self._group[contact] = parent
        return parent

    def _join(self, a: Contact, b: Contact) -> None:
        a, b = self._find(a), self._find(b)
        self._group[max(a, b)] = min(a, b)
