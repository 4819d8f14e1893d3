"""The patches of a project file as data: loops, grain, marks and what else is cut of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flatnet.parameters import FittingParameters
from flatnet.project.curve_specs import Floats
from flatnet.project.problems import Mark


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
    fold : the curve of its boundary along which it is one half of a piece.
    zone : the quality zone of a hide that it lies in; "": anywhere.
    match : all its copies lie in the same direction.
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
    fold: str | None = None
    zone: str = ""
    match: bool = False

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
