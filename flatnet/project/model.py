"""The project as data: what a project file says, checked and in mm, with the place of everything in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from flatnet.failure import Finding
from flatnet.geometry.mirror import MirrorPlane
from flatnet.parameters import STROKES, Limits, NestingParameters
from flatnet.project.curve_specs import CurveSpec, NodeSpec
from flatnet.project.hides import Hide
from flatnet.project.patch_specs import OpeningSpec, PatchSpec
from flatnet.project.problems import Mark

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


@dataclass(frozen=True)
class Material:
    """What pieces are cut from: a roll, sheets or hides; mm and degrees.

    Attributes
    ----------
    width, length : of a sheet or the longest layout on a roll; None: no limit. With hides, that of the largest.
    rotations : allowed rotations relative to the grain; None: free.
    sheets : how many sheets there are; None: as many as are needed.
    hides : in place of sheets, in the order in which they are used.
    strain : largest strain of an edge inside a piece, 0.02 is 2 %; 0: none.
    thickness : its middle lies half of this outside what it is laid on.
    """

    name: str
    width: float
    length: float | None = None
    rotations: tuple[float, ...] | None = (0.0, 180.0)
    gap: float = 0.0
    allowance: float = 0.0
    strain: float = 0.0
    thickness: float = 0.0
    sheets: int | None = None
    hides: tuple[Hide, ...] = ()

    @property
    def count(self) -> float:
        """How many sheets or hides there are; a roll is one of them, or as many as its length needs."""
        return len(self.hides) or self.sheets or np.inf

    @property
    def zones(self) -> frozenset[str]:
        """Names of the quality zones that its hides have."""
        return frozenset(name for hide in self.hides for name, _ in hide.zones)

    @property
    def one_way(self) -> bool:
        """Whether no piece may lie the other way round than another."""
        angles = [] if self.rotations is None else [angle % 360.0 for angle in self.rotations]
        return self.rotations is not None and not any((angle + 180.0) % 360.0 in angles for angle in angles)


@dataclass(frozen=True, eq=False)
class Project:
    """A project file that has been read and checked on its own; what only the geometry tells comes later.

    Everything is in mm; the file itself is in `mm_per_unit`. `findings` : what was done to the curves of drawings
    that it imports; `strokes` : meaning of a line -> its colour, #rrggbb; `exports` : formats that a build writes too.
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
    strokes: Mapping[str, str] = field(default_factory=lambda: dict(STROKES))
    exports: tuple[str, ...] = ()

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
