"""The nodes and curves of a project file as data: checked, in mm, with their places in the file."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flatnet.project.problems import Mark
from flatnet.project.seam_specs import SeamSpec

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OnRay:
    """Where a ray first meets the surface: origin (3,) mm, direction (3,) unit."""

    origin: Floats
    direction: Floats


@dataclass(frozen=True)
class AtLandmark:
    """At a landmark of the form."""

    landmark: str


@dataclass(frozen=True)
class OnLine:
    """At the fraction t of the length of a line of the form."""

    line: str
    t: float


@dataclass(frozen=True)
class OnCurve:
    """At the fraction t of the length of a curve, or of its stretch between two nodes; it is cut there."""

    curve: str
    stretch: tuple[str, str] | None
    t: float


@dataclass(frozen=True, eq=False)
class NodeSpec:
    """A node as the file gives it.

    Attributes
    ----------
    position : (3,) mm; taken to the surface where `on_surface` says so; nan where `place` says what it
        depends on.
    cast : the direction in which it is cast onto the surface first, unit; None where it is not.
    mirror_of : the node that it is the mirror image of: reflected where that is put.
    """

    name: str
    position: Floats
    on_surface: bool
    mark: Mark
    place: OnRay | AtLandmark | OnLine | OnCurve | None = None
    cast: Floats | None = None
    mirror_of: str | None = None


@dataclass(frozen=True, eq=False)
class NormalList:
    """Normals along one side of a curve.

    Attributes
    ----------
    per : `point` (values[i] at the i-th of from, points, to), `segment` (between those), or `curve` (one
        value). The last segment of a closed curve without node joins the last point to the first.
    values : (k, 3) float, unit; not yet made orthogonal to the curve.
    """

    per: Literal["point", "segment", "curve"]
    values: Floats


@dataclass(frozen=True, eq=False)
class NormalSpec:
    """Where a curve's normals come from.

    Attributes
    ----------
    source : `surface`, `curves` (from the tangents of the network's curves), `given`, or `none` (nothing said and
        no surface: no patch uses the curve).
    left, right : the lists where given; the same object off creases.
    """

    source: Literal["surface", "curves", "given", "none"]
    left: NormalList | None = None
    right: NormalList | None = None
    mark: Mark | None = None

    @property
    def crease(self) -> bool:
        """Each side of the curve has normals of its own."""
        return self.left is not self.right


@dataclass(frozen=True, eq=False)
class PlaneSection:
    """The cut of the surface with a plane, given by two of a point (3,) mm, a unit normal (3,), and the nodes."""

    point: Floats | None
    normal: Floats | None


@dataclass(frozen=True)
class MeshEdges:
    """Edges of the surface's mesh: its boundary, or those where its faces meet at more than `angle`, rad."""

    what: Literal["boundary", "feature"]
    angle: float


@dataclass(frozen=True)
class NamedLine:
    """A line of the form."""

    line: str


@dataclass(frozen=True)
class Fraction:
    """A node at the fraction t of the length of a curve's stretch, counted among those between its own nodes."""

    stretch: int
    t: float
    node: str


@dataclass(frozen=True, eq=False)
class CurveSpec:
    """A curve as the file gives it.

    Attributes
    ----------
    start, end : node names; None for a closed curve without node, equal for a closed curve with one.
    points : between start and end: a node's name, (3,) mm, or a place on a line of the form.
    closed : the last point is joined to the first.
    kind : how it runs from point to point where it follows no `path`.
    on_surface : every curve on a path is.
    edge_length : target length of its edges, mm.
    seam : how the pieces along it are cut.
    cast : direction in which its points are cast onto the surface, unit, if they are.
    path : what on the surface it follows; its points then tell the way.
    fractions : the nodes at a fraction of its length, in its order.
    mirror_of : the curve that it is the mirror image of: reflected, not drawn.
    """

    name: str
    start: str | None
    end: str | None
    points: tuple[str | Floats | OnLine, ...]
    closed: bool
    kind: Literal["polyline", "spline", "geodesic", "fair"]
    on_surface: bool
    slit: bool
    edge_length: float
    normals: NormalSpec
    mark: Mark
    seam: SeamSpec = field(default_factory=SeamSpec)
    cast: Floats | None = None
    path: PlaneSection | MeshEdges | NamedLine | None = None
    fractions: tuple[Fraction, ...] = ()
    mirror_of: str | None = None

    @property
    def own_nodes(self) -> list[str]:
        """The nodes that it is drawn through, in its order."""
        return [place for place in (self.start, *self.points, self.end) if isinstance(place, str)]

    @property
    def nodes(self) -> list[str]:
        """The nodes that it passes, in its order; the one where it starts and ends stands at both ends."""
        own = self.own_nodes
        nodes = own[:1]
        for i in range(max(len(own), 1)):
            nodes += [each.node for each in self.fractions if each.stretch == i]
            nodes += own[i + 1 : i + 2]
        return nodes
