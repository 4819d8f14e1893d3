"""The parameters that a project file may set, with their defaults, ranges and reasons.

They stand at the bottom of the package: the project room reads and checks them, the fitting and nesting rooms
use them. Lengths inside the solvers are in units of the mean edge, so that no parameter depends on the
unit of length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar


def _check(value: float, name: str, low: float, high: float) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name} must be in [{low:g}, {high:g}], got {value:g}")


#: The largest `normal_weight`, and the largest `strain_weight` and `area_weight`.
MOST_NORMAL_WEIGHT, MOST_SHAPE_WEIGHT = 1e4, 1e3


@dataclass(frozen=True)
class FairParameters:
    """The default method: soft ramp, tangential and normal steps, Newton tail (docs/method.md).

    Attributes
    ----------
    normal_weight : the user's choice between fair (small) and tangent (large): weight of the given edge
        normals against bending.
    strain_weight, area_weight : weights in the energy that keep triangles near their shape on M^p.
    ramp_steps, ramp_start, ramp_end : phase A, the soft penalty rho grows geometrically.
    tolerance : worst flattenability to reach, rad.
    max_steps : most steps of phases B and C together.
    remesh_rounds : how often at the most the flat outline is meshed anew and the mesh fitted again.
    stuck_rounds : how often at the most a mesh that is stuck or folded is refined where it is.
    """

    normal_weight: float = 1.0
    strain_weight: float = 1.0
    area_weight: float = 0.3
    ramp_steps: int = 8
    ramp_start: float = 0.1
    ramp_end: float = 100.0
    tolerance: float = 1e-9
    max_steps: int = 200
    remesh_rounds: int = 3
    stuck_rounds: int = 2

    def __post_init__(self) -> None:
        _check(self.normal_weight, "normal_weight", 0.0, MOST_NORMAL_WEIGHT)
        _check(self.strain_weight, "strain_weight", 0.0, MOST_SHAPE_WEIGHT)
        _check(self.area_weight, "area_weight", 0.0, MOST_SHAPE_WEIGHT)
        _check(self.ramp_steps, "ramp_steps", 1, 1000)
        _check(self.ramp_start, "ramp_start", 1e-6, 1e6)
        _check(self.ramp_end, "ramp_end", self.ramp_start, 1e9)
        _check(self.tolerance, "tolerance", 1e-13, 1e-1)
        _check(self.max_steps, "max_steps", 1, 100_000)
        _check(self.remesh_rounds, "remesh_rounds", 0, 20)
        _check(self.stuck_rounds, "stuck_rounds", 0, 10)


@dataclass(frozen=True)
class MultiLoopParameters:
    """Algorithm 1 of the paper as printed, with its weights (Eq. 5).

    Attributes
    ----------
    w1, w2, w3 : weights of fairness, position and cross-tangents.
    inner_steps : steps of the inner loop ('OR i > 5').
    step_tolerance : the inner loop stops when |delta| falls below it, in mean edge lengths.
    tolerance : worst flattenability to reach, rad ('epsilon').
    max_outer_loops : where the outer loop gives up.
    """

    w1: float = 1.0
    w2: float = 0.1
    w3: float = 100.0
    inner_steps: int = 5
    step_tolerance: float = 1e-5
    tolerance: float = 1e-10
    max_outer_loops: int = 60

    def __post_init__(self) -> None:
        for name in ("w1", "w2", "w3"):
            _check(getattr(self, name), name, 0.0, 1e6)
        _check(self.inner_steps, "inner_steps", 1, 1000)
        _check(self.step_tolerance, "step_tolerance", 0.0, 1.0)
        _check(self.tolerance, "tolerance", 1e-13, 1e-1)
        _check(self.max_outer_loops, "max_outer_loops", 1, 100_000)


@dataclass(frozen=True)
class BoundaryAloneParameters:
    """The last resort: a triangulation of the boundary with no vertex inside; there is nothing to choose."""

    #: By how much a flat corner may fall short of its `min_angle`, rad.
    tolerance: ClassVar[float] = 1e-9


FittingParameters = FairParameters | MultiLoopParameters | BoundaryAloneParameters

#: Name of a fitting method in the project file -> its parameters.
METHODS: dict[str, type[FittingParameters]] = {
    "fair": FairParameters,
    "multi_loop": MultiLoopParameters,
    "boundary_alone": BoundaryAloneParameters,
}


@dataclass(frozen=True)
class Limits:
    """What a patch may take before it is given up; the others go on.

    Attributes
    ----------
    seconds : by the clock.
    memory : of the process that fits it, MB (10^6 bytes).
    """

    seconds: int = 600
    memory: int = 8000

    def __post_init__(self) -> None:
        _check(self.seconds, "seconds", 1, 1_000_000)
        _check(self.memory, "memory", 300, 1_000_000_000)


#: Seconds of the nesting engine for a layout that is cut; what it finds later saves little (docs/performance.md).
FINAL_SECONDS = 60


@dataclass(frozen=True)
class NestingParameters:
    """How long and from which seed the nesting engine looks.

    Attributes
    ----------
    seconds : time the engine is given for each material, whole seconds.
    seed : its random seed.
    """

    seconds: int = 10
    seed: int = 0

    def __post_init__(self) -> None:
        _check(self.seconds, "seconds", 1, 3600)
        _check(self.seed, "seed", 0, 2**31 - 1)

    def final(self) -> NestingParameters:
        """With the time for a layout that is cut, where the engine is not given more."""
        return replace(self, seconds=max(self.seconds, FINAL_SECONDS))


#: Colours of lines by their meaning: a machine's software tells the operations apart by them.
STROKES = {
    "cut": "#ff0000",
    "sew": "#0000ff",
    "notch": "#ff00ff",
    "nick": "#ff0000",
    "internal": "#8800cc",
    "grain": "#00aa00",
    "text": "#000000",
    "sheet": "#888888",
}

#: What `flatnet export` can write.
EXPORT_FORMATS = (
    "svg",
    "dxf",
    "dxf-astm",
    "dxf-aama",
    "pdf",
    "pdf-a4",
    "pdf-letter",
    "pdf-a3",
    "pdf-a0",
    "hpgl",
    "obj",
    "glb",
    "ply",
    "sewing",
    "garmentcode",
    "cutlist",
)
