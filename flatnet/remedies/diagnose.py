"""Try cuts on a patch that failed or wrinkles, by fitting both halves of each, and rank them by what they cure."""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass
from itertools import chain, count

from flatnet.fitting.results import FailedPatch, FittedPatch, Floats
from flatnet.forms.surface import ReferenceSurface
from flatnet.geometry.triangles import bending
from flatnet.network.division import Cut, divide
from flatnet.network.network import CurveNetwork
from flatnet.network.patch import Patch
from flatnet.remedies.candidates import candidate_cuts

Result = FittedPatch | FailedPatch
#: Fits patches, each alone, and gives their results in the same order.
FitAll = Callable[[Sequence[Patch]], list[Result]]

#: How many cuts of a patch are tried.
TRIALS = 6
#: Halves that turn to and fro by this part of what the whole does are worth a cut though they wrinkle.
MUCH_LESS = 0.75


@dataclass(frozen=True, eq=False)
class Trial:
    """A cut that was made, and what came of the patches on its left and right.

    Attributes
    ----------
    network : in which the cut is the seam `seam` between the patches `parts`.
    results : of the two parts.
    """

    cut: Cut
    network: CurveNetwork
    seam: str
    parts: tuple[Patch, Patch]
    results: tuple[Result, Result]

    @property
    def unmade(self) -> int:
        return sum(isinstance(result, FailedPatch) for result in self.results)

    @property
    def wrinkled(self) -> int:
        return sum(is_wrinkled(result) for result in self.results)

    @property
    def turning(self) -> float:
        """How far the parts that were made turn to and fro where they do most, rad."""
        return max((r.mesh.wrinkles.turning for r in self.results if isinstance(r, FittedPatch)), default=0.0)

    @property
    def bending(self) -> float:
        """Sum over both meshes, without what can't be made."""
        return sum(bending(r.mesh.vertices, r.mesh.triangles) for r in self.results if isinstance(r, FittedPatch))

    @property
    def rank(self) -> tuple[float, ...]:
        """Less is better: what fails, what wrinkles and how much, how much it bends, how long the cut is."""
        return self.unmade, self.wrinkled, self.turning if self.wrinkled else 0.0, self.bending, self.cut.length


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """A patch of a network as it is, and the cuts that were tried on it, the best first."""

    network: CurveNetwork
    patch: Patch
    result: Result
    trials: tuple[Trial, ...]

    @property
    def cure(self) -> Trial | None:
        """The best cut, where it leaves less that fails or wrinkles than there is without it.

        Of a patch that can't be made one half made is a step forward, and of one that wrinkles halves that wrinkle much
        less: they may be cut again. Of one that has nothing wrong with it, the best cut that keeps it so.
        """
        if not self.trials:
            return None
        best = self.trials[0]
        if isinstance(self.result, FailedPatch):
            return best if best.unmade < 2 else None
        less = is_wrinkled(self.result) and best.turning <= MUCH_LESS * self.result.mesh.wrinkles.turning
        return best if best.unmade == 0 and (best.wrinkled == 0 or less) else None

    @property
    def cured(self) -> bool:
        """Whether the best cut leaves nothing that fails or wrinkles: it is more than a step forward."""
        return self.cure is not None and self.cure.unmade == 0 and self.cure.wrinkled == 0


def is_wrinkled(result: Result) -> bool:
    """Whether a patch wrinkles that is not meant to."""
    return isinstance(result, FittedPatch) and result.mesh.wrinkles.wrinkled and not result.patch.wrinkles_expected


def needs_cut(result: Result) -> bool:
    """Whether a patch could not be made, or wrinkles where no wrinkles were asked for."""
    return isinstance(result, FailedPatch) or is_wrinkled(result)


def diagnose(
    network: CurveNetwork,
    patch: Patch,
    result: Result,
    surface: ReferenceSurface | None,
    fit_all: FitAll,
    trials: int = TRIALS,
) -> Diagnosis:
    """Try the most promising cuts of a patch of the network.

    Parameters
    ----------
    result : what came of the patch as it is.
    fit_all : fits parts of the patch as the patch itself was fitted.
    """
    cuts = [candidate.cut for candidate in candidate_cuts(patch, surface, trials, _worst_wrinkle(result))]
    divided = [divide_by(network, patch, cut) for cut in cuts]
    results = fit_all([part for _, pair in divided for part in pair])
    tried = [
        Trial(cut, network, pair[0].boundary.stretches[-1].seam, pair, made)
        for cut, (network, pair), made in zip(cuts, divided, zip(results[::2], results[1::2]), strict=True)
    ]
    return Diagnosis(network, patch, result, tuple(sorted(tried, key=lambda trial: trial.rank)))


def _worst_wrinkle(result: Result) -> tuple[Floats, float] | None:
    """Where a patch wrinkles most, (3,) mm, and the reach of that; None where it does not."""
    if isinstance(result, FailedPatch) or not is_wrinkled(result):
        return None
    wrinkles = result.mesh.wrinkles
    return result.mesh.vertices[wrinkles.vertex], wrinkles.reach


def divide_by(network: CurveNetwork, patch: Patch, cut: Cut) -> tuple[CurveNetwork, tuple[Patch, Patch]]:
    """The network in which a patch is divided, and its parts; seam, nodes and parts have the first names that are free.

    The cut is the last stretch round both parts.
    """
    seam = free_name(f"{patch.name}_cut", network.stretches)
    nodes = free_name(f"{seam}_a", network.nodes), free_name(f"{seam}_b", network.nodes)
    names = {p.name for p in network.patches}
    parts = free_name(f"{patch.name}_1", names), free_name(f"{patch.name}_2", names)
    network = divide(network, patch.name, cut, seam, parts, nodes)
    return network, (patch_of(network, parts[0]), patch_of(network, parts[1]))


def patch_of(network: CurveNetwork, name: str) -> Patch:
    """The patch of this name."""
    return next(patch for patch in network.patches if patch.name == name)


def free_name(name: str, taken: Container[str]) -> str:
    """The name, or the first of name_2, name_3 ... that is not taken."""
    names = chain([name], (f"{name}_{k}" for k in count(2)))
    return next(name for name in names if name not in taken)
