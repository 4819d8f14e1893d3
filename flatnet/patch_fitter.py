"""Fit patches side by side in worker processes, within the limits of a project."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from types import TracebackType

from flatnet.failure import REPORT_IT, Finding
from flatnet.fitting.results import FailedPatch, FittedPatch
from flatnet.fitting.run import run_patch
from flatnet.geometry.polygon import side_lengths
from flatnet.network.patch import Patch
from flatnet.parameters import FittingParameters, Limits
from flatnet.workers import Lost, Workers, usable_cores

#: What makes of a patch what it can; a function of a module, called in another process.
Fit = Callable[[Patch, FittingParameters], FittedPatch | FailedPatch]


class PatchFitter:
    """Worker processes that fit patches; they start when the `with` statement is entered, which takes a second.

    Parameters
    ----------
    limits : of one patch.
    most : of how many patches at once there is use.
    workers : how many are fitted at once; None: one for each core that may be used.
    """

    def __init__(self, limits: Limits, most: int, workers: int | None = None, fit: Fit = run_patch) -> None:
        self._limits = limits
        self._crew = Workers(fit, min(workers or usable_cores(), most), limits)

    def __enter__(self) -> PatchFitter:
        self._crew.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._crew.__exit__(kind, error, trace)

    def dismiss(self) -> None:
        """End the processes before the `with` statement does."""
        self._crew.dismiss()

    def fit(
        self,
        work: Iterable[tuple[Patch, FittingParameters]],
        note: Callable[[str, FittedPatch | FailedPatch], None] = lambda *_: None,
    ) -> list[FittedPatch | FailedPatch]:
        """Every patch's result, in their order, the heaviest begun first; one that fails stops no other.

        Parameters
        ----------
        note : called with the name and result of every patch as it ends.
        """
        tasks = list(work)
        order = sorted(range(len(tasks)), key=lambda i: _edges_around(tasks[i][0]), reverse=True)
        results: dict[int, FittedPatch | FailedPatch] = {}
        for at, result in self._crew.run([tasks[i] for i in order]):
            name = tasks[order[at]][0].name
            done = FailedPatch(name, _given_up(name, result, self._limits)) if isinstance(result, Lost) else result
            results[order[at]] = done
            note(name, done)
        return [results[i] for i in range(len(tasks))]

    def fit_alike(
        self, parameters: FittingParameters
    ) -> Callable[[Sequence[Patch]], list[FittedPatch | FailedPatch]]:
        """What fits patches with the same parameters, as parts of one patch are."""
        return lambda patches: self.fit((patch, parameters) for patch in patches)


def _edges_around(patch: Patch) -> float:
    """Mesh edges along the boundary: what fitting takes grows with it."""
    return float(side_lengths(patch.boundary.vertices).sum()) / patch.edge_length


def _given_up(name: str, lost: Lost, limits: Limits) -> Finding:
    """Why a patch came to nothing, not even to a failure of its own."""
    finding = Finding("internal_error", "fitting", "", REPORT_IT, name, details=lost.details)
    if lost.reason == "itself":
        return replace(finding, message=f"the process that fitted it ended with {lost.ending}.")
    smaller = "Use a larger edge_length for the patch, or cut it in two; or give it more by"
    if lost.reason == "memory":
        return replace(
            finding,
            message=f"it took {lost.megabytes:.0f} MB; `limits` allow {limits.memory}.",
            remedy=f"{smaller} `limits: {{memory: ...}}`.",
            amount=lost.megabytes,
            unit="MB",
        )
    return replace(
        finding,
        code="time_limit",
        message=f"it was not done after {lost.seconds:.0f} s; `limits` allow {limits.seconds}.",
        remedy=f"{smaller} `limits: {{seconds: ...}}`.",
        amount=lost.seconds,
        unit="s",
    )
