"""The project as data: what a project file says, checked and in mm, with the place of everything in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flatnet.failure import Finding
from flatnet.geometry.mirror import MirrorPlane
from flatnet.parameters import FittingParameters, Limits, NestingParameters

Floats = NDArray[np.float64]


@dataclass(frozen=True, order=True)
class Mark:
    """A place in the project file; line and column count from 1."""

    line: int
    column: int


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with a project, where it stands and what to do."""

    mark: Mark | None
    message: str

    def located(self, file: Path) -> str:
        """The message behind its place, as an editor finds it: file:line:column."""
        place = f"{file}:{self.mark.line}:{self.mark.column}" if self.mark else str(file)
        return f"{place}: {self.message}"


class ProjectError(Exception):
    """The project is invalid: all its problems together, in file order."""

    def __init__(self, file: Path, problems: list[Problem]) -> None:
        self.file = file
        self.problems = sorted(problems, key=lambda p: p.mark or Mark(0, 0))
        super().__init__("\n".join(problem.located(file) for problem in self.problems))


#: Measurements of forms that are plain numbers, not lengths.
PLAIN_NUMBERS = ("size",)


@dataclass(frozen=True, eq=False)
class FormSurface:
    """A parametric form of ours; lengths among `measurements` in mm.

    Which measurements a form has and what they may be, the form checks.

    clearance : how far patches may cut into it before they are warned of, mm.
    """

    form: str
    measurements: Mapping[str, float | str]
    mark: Mark
    clearance: float = 0.0


@dataclass(frozen=True, eq=False)
class MeshSurface:
    """A mesh file of the user; `outer` is the side that the normals point to, `clearance` as of a form."""

    path: Path
    mm_per_unit: float
    up: Literal["x", "y", "z"]
    outer: Literal["outside", "inside"]
    mark: Mark
    clearance: float = 0.0


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


@dataclass(frozen=True)
class Ends:
    """How an allowance ends at the corners of a piece.

    Attributes
    ----------
    kind : `mitre` (the parallels are drawn on until they meet), `bevel` (straight from the end of the one to that of
        the other), `mirrored` (as the cut line of the neighbouring edge, mirrored in this sew line: both lie on each
        other when the allowance is folded over), `square` (at a right angle to this sew line).
    length : how far a mitre may reach from the sew line's corner, mm; None: the usual limit.
    """

    kind: Literal["mitre", "bevel", "mirrored", "square"] = "mitre"
    length: float | None = None

    @property
    def is_folded(self) -> bool:
        """Whether the end belongs to one of the two edges."""
        return self.kind in ("mirrored", "square")


@dataclass(frozen=True)
class NotchSpec:
    """Notches of a curve, cut into the allowances of the pieces on both sides.

    Attributes
    ----------
    every : distance from the start of each stretch, again and again, mm; None: no such row.
    at, at_parts : single places along the whole curve, mm and parts of its length.
    nodes : at the nodes that the curve passes, on pieces whose outline runs straight on there.
    marks : how many side by side at each; None: as many as tell seams apart that are alike.
    depth : from the cut line, mm.
    """

    every: float | None = None
    at: tuple[float, ...] = ()
    at_parts: tuple[float, ...] = ()
    nodes: bool = False
    kind: Literal["slit", "T", "V", "castle"] = "slit"
    marks: int | None = None
    depth: float = 4.0


@dataclass(frozen=True)
class DartSpec:
    """A slit that is sewn closed with what opens between its sides folded to one side of the curve's direction.

    Attributes
    ----------
    drill : distance of the drill hole from the tip, mm.
    """

    fold: Literal["left", "right"]
    drill: float = 10.0


@dataclass(frozen=True)
class SeamSpec:
    """How the pieces along a curve are cut.

    Attributes
    ----------
    left, right : allowance of the piece on that side of the curve's direction, mm; None: as its patch says.
    ends : how the allowances end at corners.
    notches : None: no notches.
    dart : None: no dart; a slit is cut open like any seam.
    """

    left: float | None = None
    right: float | None = None
    ends: Ends = Ends()
    notches: NotchSpec | None = None
    dart: DartSpec | None = None


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
    seam: SeamSpec = SeamSpec()
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


@dataclass(frozen=True)
class SignedCurve:
    """An entry of `around`: a curve, or one stretch of it (between two nodes), forwards or backwards."""

    curve: str
    reversed: bool
    stretch: tuple[str, str] | None
    mark: Mark

    def __str__(self) -> str:
        stretch = f":{self.stretch[0]}..{self.stretch[1]}" if self.stretch else ""
        return f"{'-' if self.reversed else ''}{self.curve}{stretch}"


@dataclass(frozen=True, eq=False)
class GrainSpec:
    """What is laid along the material's grain: one of a direction, two nodes, or a curve.

    Attributes
    ----------
    direction : (3,) unit, in space.
    nodes : from the first to the second, on the flat piece where both are on its boundary.
    curve : along it, as far as the patch reaches, forwards or backwards.
    said : the file says so; where it does not, a patch on which `direction` is nowhere is laid by its extent.
    """

    direction: Floats | None = None
    nodes: tuple[str, str] | None = None
    curve: SignedCurve | None = None
    said: bool = True


#: Kinds of marks; the first is what one is of which nothing is said.
LINE_MARKS = ("line", "stitch", "skive", "stripe", "fold")
POINT_MARKS = ("drill", "eyelet")


@dataclass(frozen=True, eq=False)
class MarkSpec:
    """A line or point on a patch that is drawn on its piece and not cut.

    Attributes
    ----------
    points : (3,) mm each, on the patch or near it; one for a point.
    spline : the line is smooth.
    closed : its last point is joined to the first.
    diameter : of a hole at a point, mm.
    """

    name: str
    kind: str
    points: tuple[Floats, ...]
    spline: bool
    closed: bool
    diameter: float | None
    mark: Mark


@dataclass(frozen=True)
class AlsoSpec:
    """The same patch cut from a further material: lining, interfacing.

    Attributes
    ----------
    cut, mirrored : plain and mirrored copies.
    allowance : along all its edges, over what curves and patch say, mm; None: as they say.
    """

    material: str
    cut: int
    mirrored: int
    allowance: float | None = None


@dataclass(frozen=True, eq=False)
class PatchSpec:
    """A patch as the file gives it.

    Attributes
    ----------
    loops : one tuple of signed curves per boundary loop (more than one: not a disk).
    grain : None: it has none.
    min_angles : node name -> rad.
    fitting : the method of this patch, as its parameters.
    allowance : of its edges whose curves say nothing, mm; None: as its material says.
    wrinkles_expected : it is meant to wrinkle: no warning.
    also : what else is cut of it, one of each material.
    marks : what is drawn on it.
    simple_outline : a flat outline that crosses itself is opened.
    mirror_of : the patch that it is the mirror image of: reflected, not fitted.
    """

    name: str
    loops: tuple[tuple[SignedCurve, ...], ...]
    material: str
    cut: int
    mirrored: int
    grain: GrainSpec | None
    edge_length: float
    min_angles: Mapping[str, float]
    fitting: FittingParameters
    mark: Mark
    allowance: float | None = None
    wrinkles_expected: bool = False
    also: tuple[AlsoSpec, ...] = ()
    marks: tuple[MarkSpec, ...] = ()
    simple_outline: bool = False
    mirror_of: str | None = None

    @property
    def materials(self) -> tuple[str, ...]:
        """All materials that it is cut from."""
        return (self.material, *(also.material for also in self.also))


@dataclass(frozen=True, eq=False)
class OpeningSpec:
    """A face that is no patch, by its loops as in `PatchSpec`."""

    name: str
    loops: tuple[tuple[SignedCurve, ...], ...]
    mark: Mark


@dataclass(frozen=True)
class Material:
    """A roll that pieces are cut from; mm and degrees.

    Attributes
    ----------
    rotations : allowed rotations relative to the grain; None: free.
    length : longest layout; None: no limit.
    strain : largest strain of an edge inside a piece, 0.02 is 2 %; 0: none.
    """

    name: str
    width: float
    length: float | None = None
    rotations: tuple[float, ...] | None = (0.0, 180.0)
    gap: float = 0.0
    allowance: float = 0.0
    strain: float = 0.0

    @property
    def one_way(self) -> bool:
        """Whether no piece may lie the other way round than another."""
        angles = [] if self.rotations is None else [angle % 360.0 for angle in self.rotations]
        return self.rotations is not None and not any((angle + 180.0) % 360.0 in angles for angle in angles)


@dataclass(frozen=True, eq=False)
class Project:
    """A project file that has been read and checked on its own; what only the geometry tells comes later.

    Everything is in mm; the file itself is in `mm_per_unit`. `findings` : what was done to the curves of drawings
    that it imports.
    """

    file: Path
    name: str
    mm_per_unit: float
    edge_length: float
    chord_tolerance: float
    surface: FormSurface | MeshSurface | None
    nodes: Mapping[str, NodeSpec]
    curves: Mapping[str, CurveSpec]
    patches: Mapping[str, PatchSpec]
    openings: Mapping[str, OpeningSpec]
    rest_is_open: bool
    materials: Mapping[str, Material]
    size: str = ""
    nesting: NestingParameters = field(default_factory=NestingParameters)
    limits: Limits = field(default_factory=Limits)
    findings: tuple[Finding, ...] = ()
    joins_crossings: bool = False
    mirror: MirrorPlane | None = None

    @property
    def title(self) -> str:
        """Name and size, as printed on pieces and layouts."""
        return f"{self.name} · {self.size}" if self.size else self.name

    def as_drawn(self) -> Project:
        """The project without the nodes and curves that are mirror images."""
        return replace(
            self,
            nodes={name: node for name, node in self.nodes.items() if node.mirror_of is None},
            curves={name: curve for name, curve in self.curves.items() if curve.mirror_of is None},
        )

    @property
    def clearance(self) -> float:
        """How far patches may cut into the surface before they are warned of, mm; 0 without one."""
        return self.surface.clearance if self.surface else 0.0
