"""Hides: the key `hides` of a material, outlines with defects and quality zones, in YAML or from drawings."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import shapely
import yaml
from shapely import MultiPolygon, Polygon

from flatnet.project.drawings.file_curve import closed_paths, refined
from flatnet.project.imports import read_drawing_at
from flatnet.project.section import Section
from flatnet.project.values import LARGEST_LENGTH, NAME, Parser, WrongValueError, length_in, unit, wrong
from flatnet.project.yaml_nodes import mark_of

#: (x, y) in mm, closed.
Ring = tuple[tuple[float, float], ...]

#: Chords leave a drawn rim by less, mm.
CHORD = 0.1
_HIDE_KEYS = ("outline", "units", "defects", "zones")
#: A curve of a drawing that is the zone A is named so; a name in SVG or a layer in DXF.
_ZONE = re.compile(rf"zone[_.\- ]({NAME})", re.IGNORECASE)


@dataclass(frozen=True)
class Hide:
    """A sheet that grew: mm, x along the back, seen from the side that normals point to; its box starts at (0, 0).

    Attributes
    ----------
    defects : what pieces stay off.
    zones : name of a quality -> where it is; one may lie in another.
    """

    outline: Ring
    defects: tuple[Ring, ...] = ()
    zones: tuple[tuple[str, Ring], ...] = ()

    @cached_property
    def region(self) -> Polygon | MultiPolygon:
        """Where pieces may lie."""
        return Polygon(self.outline).difference(shapely.union_all([Polygon(ring) for ring in self.defects]))

    def zone(self, name: str) -> Polygon | MultiPolygon:
        """Where pieces that ask for a zone may lie; nowhere on a hide without it."""
        rings = [Polygon(ring) for own, ring in self.zones if own == name]
        return self.region.intersection(shapely.union_all(rings))

    @property
    def area(self) -> float:
        """mm^2 inside the outline, defects too."""
        return float(Polygon(self.outline).area)

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y, mm."""
        length, width = np.array(self.outline).max(axis=0).tolist()
        return length, width


def read_hides(file: Path, material: Section, mm_per_unit: float) -> tuple[Hide, ...]:
    """The hides of a material: one, or a list."""
    node = material.values.get("hides")
    if node is None:
        return ()
    listed = isinstance(node, yaml.SequenceNode)
    items = material.items("hides", node, "") if listed else [("hides", node)]
    if listed and not items:
        material.problem(node, "hides: there is none; leave the key out, or give an outline")
    hides = []
    for label, item in items:
        section = Section(item, f"{material.title}: {label}", mark_of(item), _HIDE_KEYS, material.problems)
        hide = _hide(file, section, mm_per_unit)
        if hide is not None:
            hides.append(hide)
    return tuple(hides)


def _hide(file: Path, section: Section, mm_per_unit: float) -> Hide | None:
    before = len(section.problems)
    ring = _ring_in(mm_per_unit)
    outline: Ring = ()
    defects: list[Ring] = []
    zones: list[tuple[str, Ring]] = []
    if "outline" not in section.values:
        section.problem(section.mark, "'outline' is missing; a list of points [x, y], or an SVG or DXF file")
    elif isinstance(section.values["outline"], yaml.SequenceNode):
        outline = section.get("outline", ring, ())
        if "units" in section.values:
            section.problem(section.keys["units"], "'units' are those of a drawing; points are in the file's own")
    else:
        outline, defects, zones = _drawn(file, section, section.get("units", unit, mm_per_unit))
    if "defects" in section.values:
        for label, item in section.items("defects", section.values["defects"], "a list of outlines"):
            defects.append(section.read(label, item, ring, ()))
    named = section.section("zones", None)
    for key, _, item in named.named():
        zones.append((key, named.read(key, item, ring, ())))
    if len(section.problems) > before:
        return None
    body = Polygon(outline)
    for what, other in [*(("a defect", d) for d in defects), *((f"zone {key!r}", z) for key, z in zones)]:
        if not body.intersects(Polygon(other)):
            section.problem(section.mark, f"{what} lies off the hide, at x = {other[0][0]:g}, y = {other[0][1]:g} mm")
    left, bottom = np.array(outline).min(axis=0).tolist()
    return Hide(
        _moved(outline, left, bottom),
        tuple(_moved(defect, left, bottom) for defect in defects),
        tuple((key, _moved(zone, left, bottom)) for key, zone in zones),
    )


def _moved(ring: Ring, left: float, bottom: float) -> Ring:
    return tuple((x - left, y - bottom) for x, y in ring)


def _ring_in(mm_per_unit: float) -> Parser[Ring]:
    """[[x, y], [x, y], [x, y], ...] in the file's unit; an outline that does not cross itself."""
    coordinate = length_in(mm_per_unit)
    expected = "three or more points [x, y]"

    def parser(node: yaml.Node) -> Ring:
        if not isinstance(node, yaml.SequenceNode) or len(node.value) < 3:
            raise wrong(node, expected)
        points = []
        for item in node.value:
            if not isinstance(item, yaml.SequenceNode) or len(item.value) != 2:
                raise wrong(item, "a point [x, y]")
            x, y = (coordinate(number) for number in item.value)
            points.append((x, y))
        if not Polygon(points).is_valid:
            reason = shapely.is_valid_reason(Polygon(points))
            raise WrongValueError(node, f"expected an outline that does not cross itself: {reason} mm")
        return tuple(points)

    return parser


def _drawn(
    file: Path, section: Section, scale: float
) -> tuple[Ring, list[Ring], list[tuple[str, Ring]]]:
    """Outline, defects and zones of a drawing: its largest closed curve, and those inside it."""
    nothing: tuple[Ring, list[Ring], list[tuple[str, Ring]]] = ((), [], [])
    node = section.values["outline"]
    before = len(section.problems)
    parts = read_drawing_at(file, section, "outline", node)
    read = closed_paths([refined(part, CHORD / scale) for part in parts])
    curves = [c for c in read if c.closed and len(c.points) > 3]
    if len(section.problems) > before:
        return nothing
    rings: list[tuple[str, Ring]] = [
        (curve.name, tuple((float(x), float(y)) for x, y in scale * curve.points[:-1, :2])) for curve in curves
    ]
    if not rings:
        section.problem(node, "outline: the drawing has no closed curve")
        return nothing
    for drawn, ring in rings:
        if not Polygon(ring).is_valid or np.abs(np.array(ring)).max() > LARGEST_LENGTH:
            section.problem(node, f"outline: a curve ({drawn or 'without name'}) crosses itself, or is much too large")
            return nothing
    rings.sort(key=lambda entry: -Polygon(entry[1]).area)
    zones = [(found[1], ring) for drawn, ring in rings[1:] if (found := _ZONE.fullmatch(drawn))]
    defects = [ring for drawn, ring in rings[1:] if not _ZONE.fullmatch(drawn)]
    return rings[0][1], defects, zones

