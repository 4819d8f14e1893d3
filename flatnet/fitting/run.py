"""Run one patch: what comes back is a fitted or a failed patch, never an exception."""

from __future__ import annotations

from flatnet.failure import Finding, PatchFailure
from flatnet.fitting.fit import fit_patch
from flatnet.fitting.results import FailedPatch, FittedPatch
from flatnet.network.patch import Patch
from flatnet.parameters import FittingParameters


def run_patch(patch: Patch, parameters: FittingParameters) -> FittedPatch | FailedPatch:
    """Fit one patch; the one place where its failures are caught."""
    seconds: dict[str, float] = {}
    try:
        return fit_patch(patch, parameters, seconds)
    except PatchFailure as failure:
        return FailedPatch(patch.name, failure.finding.on(patch.name), seconds=seconds)
    except Exception as error:
        return FailedPatch(patch.name, Finding.of_a_bug(patch.name, "fitting", error), seconds=seconds)
