"""Drawn curves -> a network: nodes where curves meet, curves from node to node, and what was done to them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from flatnet.failure import Finding
from flatnet.geometry.polygon import polyline_length
from flatnet.project.drawings.contacts import Contact, Joints
from flatnet.project.drawings.file_curve import FileCurve, Floats

#: Points nearer than this, over the extent of the drawing, are the same point.
SAME_POINT = 1e-9
#: Ends that stay apart are named up to this many times the tolerance.
NEAR = 10.0
#: In place of a tolerance of 0 in that, over the extent of the drawing.
SMALLEST_SNAP = 1e-4
#: Two-point lines that follow each other are one curve unless they turn by more than this, rad.
CORNER = np.radians(30.0)


@dataclass(frozen=True, eq=False)
class JoinedCurve:
    """A curve of the network.

    Attributes
    ----------
    places : nodes by name, and points (3,) in mm. A closed curve with a node has it at both ends; without one the
        last point is joined to the first, which is not repeated.
    smooth : drawn as a smooth curve, not as a polyline.
    """

    places: tuple[str | Floats, ...]
    closed: bool
    smooth: bool


@dataclass(frozen=True, eq=False)
class JoinedDrawing:
    """Nodes (mm) and curves by name, in the order of the drawing, and what was moved, left out or missed."""

    nodes: Mapping[str, Floats]
    curves: Mapping[str, JoinedCurve]
    findings: tuple[Finding, ...]


@dataclass(frozen=True, eq=False)
class _Span:
    """A curve between two of its nodes: their names and the points between them."""

    start: str
    points: Floats
    end: str

    @property
    def length(self) -> float:
        return polyline_length(self.points)


def join_curves(
    drawn: Sequence[FileCurve], snap: float, join_crossings: bool = False, trim: bool = False, prefix: str = ""
) -> JoinedDrawing:
    """Make a network of drawn curves.

    Curves that have a point in common share a node there. Ends within `snap` of each other, or of another curve,
    become one node and are moved to it. Every end that was moved is a finding, and so are ends that are near
    and stay apart, crossings without a node, and what was left out.

    Parameters
    ----------
    drawn : in mm.
    snap : mm.
    join_crossings : curves that pass each other within `snap` get a node there.
    trim : what runs from the network to an end where nothing follows is left out.
    prefix : of the names of nodes and curves.
    """
    extent = float(np.ptp(np.concatenate([curve.points for curve in drawn]), axis=0).max())
    same = SAME_POINT * extent
    curves = _named(_chained(_without_repeats(drawn, same), same), prefix)
    joints = Joints(curves, same)
    if snap > same:
        joints.snap_ends(snap)
        joints.snap_onto(snap)
    findings: list[Finding] = []
    for crossing in joints.crossings(max(snap, same)):
        if join_crossings:
            joints.join_crossing(crossing)
        a, b = (curves[contact[0]].name for contact in (crossing.first, crossing.second))
        findings.append(_crossing(a, b, crossing.gap, crossing.place, join_crossings))

    groups = joints.groups()
    places = {f"{prefix}n{i}": joints.place(group) for i, group in enumerate(groups, 1)}
    at = {contact: node for node, group in zip(places, groups) for contact in group}
    findings += _snapped(joints, places, at)
    spans = [_spans(i, curve, at, places) for i, curve in enumerate(curves)]
    findings += _near_misses(joints, places, spans, snap or SMALLEST_SNAP * extent)
    if trim:
        spans, trimmed = _trimmed(joints, spans)
        findings += trimmed
    nodes, network = _assembled(curves, spans, places)
    return JoinedDrawing(nodes, network, tuple(findings))


def _without_repeats(drawn: Sequence[FileCurve], same: float) -> list[FileCurve]:
    """The curves without points that repeat the one before; those that are one point only are left out."""
    kept = []
    for curve in drawn:
        steps = np.linalg.norm(np.diff(curve.points, axis=0), axis=1)
        points = curve.points[np.concatenate([[True], steps > same])]
        if len(points) > 1:
            points = points.copy()
            points[-1] = curve.points[-1]
            kept.append(replace(curve, points=points))
    return kept


def _chained(curves: Sequence[FileCurve], same: float) -> list[FileCurve]:
    """Two-point lines that follow each other without a corner, and nothing else meets there, as one polyline each."""
    lines = [i for i, curve in enumerate(curves) if len(curve.points) == 2]
    every = np.concatenate([curve.points for curve in curves])
    tree = cKDTree(every)
    label = np.arange(len(every))
    for i, j in sorted(tree.query_pairs(same)):
        label[j] = label[i]
    offset = np.concatenate([[0], np.cumsum([len(curve.points) for curve in curves])])
    uses = Counter(label.tolist())
    at: dict[int, list[tuple[int, int]]] = {}  # point -> lines that end there, with their end
    for i in lines:
        for end in (0, 1):
            at.setdefault(int(label[offset[i] + end]), []).append((i, end))

    def following(line: int, end: int) -> tuple[int, int] | None:
        """The line that goes on at an end of a line, and the end that it is entered at."""
        point = int(label[offset[line] + end])
        if uses[point] != 2 or len(at[point]) != 2:
            return None
        other = next(entry for entry in at[point] if entry != (line, end))
        u = curves[line].points[end] - curves[line].points[1 - end]
        v = curves[other[0]].points[1 - other[1]] - curves[other[0]].points[other[1]]
        straight = u @ v >= np.cos(CORNER) * np.linalg.norm(u) * np.linalg.norm(v)
        return other if straight and other[0] != line else None

    result = []
    used: set[int] = set()
    for i, curve in enumerate(curves):
        if len(curve.points) > 2:
            result.append(curve)
        elif i not in used:
            start = (i, 0)  # walk back to where the chain begins; round a closed one to the line itself
            while (back := following(*start)) and back[0] != i:
                start = back[0], 1 - back[1]
            step: tuple[int, int] | None = start
            points = [curves[start[0]].points[start[1]]]
            while step is not None and step[0] not in used:
                line, entered = step
                used.add(line)
                points.append(curves[line].points[1 - entered])
                step = following(line, 1 - entered)
            if step is not None:  # a closed chain
                points[-1] = points[0]
            result.append(FileCurve(curve.name, np.array(points)))
    return result


def _named(curves: Sequence[FileCurve], prefix: str) -> list[FileCurve]:
    """Curves with names that a project file can hold, each its own."""
    plain = ["_".join(re.findall(r"\w+", curve.name)) for curve in curves]
    total, seen = Counter(plain), Counter[str]()
    taken = {name for name in plain if total[name] == 1}
    named = []
    for name, curve in zip(plain, curves):
        unique = name
        while total[name] > 1 and (unique == name or unique in taken):
            seen[name] += 1
            unique = f"{name}-{seen[name]}" if name else f"c{seen[name]}"
        unique = unique or "c1"
        taken.add(unique)
        named.append(replace(curve, name=prefix + unique))
    return named


def _spans(
    i: int, curve: FileCurve, at: Mapping[Contact, str], places: Mapping[str, Floats]
) -> list[_Span]:
    """A curve from node to node; [] where it is closed and passes none."""
    stops = sorted(contact for contact in at if contact[0] == i)
    last = len(curve.points) - 1.0
    if curve.closed and stops:
        stops = [*stops, (i, stops[0][1] + last)]
    doubled = np.concatenate([curve.points, curve.points[1:]]) if curve.closed else curve.points
    spans = []
    for a, b in pairwise(stops):
        start, end = at[a], at.get(b) or at[stops[0]]
        inner = doubled[int(np.floor(a[1])) + 1 : int(np.ceil(b[1]))]
        span = _Span(start, np.concatenate([[places[start]], inner, [places[end]]]), end)
        if start != end or len(inner) > 1:  # else it has vanished in the node
            spans.append(span)
    return spans


def _trimmed(joints: Joints, spans: Sequence[list[_Span]]) -> tuple[list[list[_Span]], list[Finding]]:
    """The spans that lie between two loops' nodes, or in a loop, and a finding for every one that does not."""
    findings: list[Finding] = []
    kept = [list(each) for each in spans]
    while True:
        degree = _degrees(kept)
        dead = [
            (i, s) for i, each in enumerate(kept) for s in each if degree[s.start] == 1 or degree[s.end] == 1
        ]
        if not dead:
            return kept, findings
        for i, span in dead:
            kept[i].remove(span)
            node, end = (span.start, span.points[0]) if degree[span.start] == 1 else (span.end, span.points[-1])
            name = joints.curves[i].name
            findings.append(
                Finding(
                    code="trimmed_end",
                    stage="import",
                    where=_place(end),
                    amount=span.length,
                    unit="mm",
                    message=f"curve '{name}' runs to node '{node}' at {_place(end)}, where nothing follows: "
                    f"{span.length:.4g} mm of it are left out{_nearest(joints, end, i)}.",
                    remedy="If it should end at another curve, raise snap or let it reach there; or leave trim out and "
                    "say slit: true to cut the face open along it.",
                )
            )


def _degrees(spans: Sequence[list[_Span]]) -> Counter[str]:
    return Counter(node for each in spans for span in each for node in (span.start, span.end))


def _nearest(joints: Joints, end: Floats, own: int) -> str:
    nearest = joints.segments.nearest_other(end, own)
    if nearest is None:
        return ""
    return f"; the nearest curve is '{joints.curves[nearest[0]].name}', gap {nearest[1]:.4g} mm"


def _assembled(
    curves: Sequence[FileCurve], spans: Sequence[list[_Span]], places: Mapping[str, Floats]
) -> tuple[dict[str, Floats], dict[str, JoinedCurve]]:
    """Curves of consecutive spans, and the nodes that they meet at or end at.

    A node that one curve alone passes is none. A curve that passes a node twice is divided there, and one that
    was trimmed in its middle into its parts: `name-1`, `name-2`.
    """
    degree = _degrees(spans)
    used: set[str] = set()
    network: dict[str, JoinedCurve] = {}
    for curve, each in zip(curves, spans):
        if not each:
            if curve.closed and not any(name == curve.name for name in network):
                network[curve.name] = JoinedCurve(tuple(curve.points[:-1]), True, curve.smooth)
            continue
        runs = _runs(each, degree)
        for k, run in enumerate(runs, 1):
            points: list[str | Floats] = [run[0].start]
            for span, following in zip(run, [*run[1:], None]):
                points += [point for point in span.points[1:-1]]
                passed_alone = following is not None and degree[span.end] == 2
                points.append(span.points[-1] if passed_alone else span.end)
            used.update(point for point in points if isinstance(point, str))
            name = curve.name if len(runs) == 1 else f"{curve.name}-{k}"
            network[name] = JoinedCurve(tuple(points), run[0].start == run[-1].end, curve.smooth)
    return {node: place for node, place in places.items() if node in used}, network


def _runs(spans: Sequence[_Span], degree: Mapping[str, int]) -> list[list[_Span]]:
    """Spans that follow each other, in runs that pass no node twice."""
    runs: list[list[_Span]] = []
    for span in spans:
        run = runs[-1] if runs else []
        passed = [each.start for each in [*run, span]]
        if not run or run[-1].end != span.start or run[-1].end == run[0].start:
            runs.append([span])
        elif span.end in passed[1:]:
            cut = passed.index(span.end)
            runs[-1:] = [run[:cut], [*run[cut:], span]]
        else:
            run.append(span)
    return runs


def _snapped(joints: Joints, places: Mapping[str, Floats], at: Mapping[Contact, str]) -> list[Finding]:
    """A finding for every end that was moved to its node."""
    findings = []
    for contact, node in sorted(at.items()):
        moved = float(np.linalg.norm(joints.position(contact) - places[node]))
        if moved <= joints.same or not joints.is_end(contact):
            continue
        name = joints.curves[contact[0]].name
        others = dict.fromkeys(joints.curves[i].name for (i, _), other in at.items() if other == node)
        others.pop(name, None)
        meets = ", ".join(f"'{other}'" for other in others) or "its own other end"
        which = "start" if contact[1] == 0.0 else "end"
        findings.append(
            Finding(
                code="snapped_end",
                stage="import",
                where=_place(places[node]),
                amount=moved,
                unit="mm",
                message=f"the {which} of curve '{name}' was moved by {moved:.4g} mm to node '{node}' at "
                f"{_place(places[node])}, where it meets {meets}.",
                remedy="",
            )
        )
    return findings


def _near_misses(
    joints: Joints, places: Mapping[str, Floats], spans: Sequence[list[_Span]], snap: float
) -> list[Finding]:
    """Ends that follow nothing and nodes that nothing joins, near to something else and beyond the tolerance."""
    degree = _degrees(spans)
    findings = []
    free = {
        node: (i, end)
        for i, each in enumerate(spans)
        for span in each
        for node, end in ((span.start, span.points[0]), (span.end, span.points[-1]))
        if degree[node] == 1
    }
    for node, (i, end) in free.items():
        nearest = joints.segments.nearest_other(end, i)
        if nearest is not None and nearest[1] <= NEAR * snap:
            what = f"curve '{joints.curves[i].name}' ends at node '{node}', {_place(end)}, and follows nothing"
            findings.append(_near_miss(what, f"curve '{joints.curves[nearest[0]].name}'", nearest[1], end))
    names = list(places)
    tree = cKDTree(np.array(list(places.values())).reshape(-1, 3))
    linked = {
        frozenset((span.start, span.end)) for each in spans for span in each if span.length <= 2.0 * NEAR * snap
    }
    for i, j in sorted(tree.query_pairs(NEAR * snap)):
        a, b = names[i], names[j]
        if degree[a] > 1 and degree[b] > 1 and frozenset((a, b)) not in linked:
            gap = float(np.linalg.norm(places[a] - places[b]))
            findings.append(_near_miss(f"node '{a}' at {_place(places[a])}", f"node '{b}'", gap, places[a]))
    return findings


def _near_miss(what: str, other: str, gap: float, place: Floats) -> Finding:
    return Finding(
        code="near_miss",
        stage="import",
        where=_place(place),
        amount=gap,
        unit="mm",
        message=f"{what}; {other} is {gap:.4g} mm away, beyond the tolerance, and they stay apart.",
        remedy="If they belong together, raise snap.",
    )


def _crossing(a: str, b: str, gap: float, place: Floats, joined: bool) -> Finding:
    what = "a node joins them" if joined else "they have no node there"
    return Finding(
        code="crossing_curves",
        stage="import",
        where=_place(place),
        amount=gap,
        unit="mm",
        message=f"curves '{a}' and '{b}' cross at {_place(place)}, {gap:.4g} mm apart: {what}.",
        remedy="" if joined else "If they belong together, say join: crossings.",
    )


def _place(point: Floats) -> str:
    return f"({point[0]:.4g}, {point[1]:.4g}, {point[2]:.4g})"
