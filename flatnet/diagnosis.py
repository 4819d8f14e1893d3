"""A project file in, and for every patch that fails or wrinkles the cuts that were tried on it out."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from flatnet.build import Progress
from flatnet.failure import Finding
from flatnet.forms import make_surface
from flatnet.network.assembly import make_network
from flatnet.patch_fitter import PatchFitter
from flatnet.project import Project, load_project
from flatnet.remedies.diagnose import TRIALS, Diagnosis, FitAll, diagnose, needs_cut
from flatnet.remedies.ring_seam import RingSeam, ring_seam


class NoSuchPatchError(Exception):
    """A patch was named that the project has not."""


@dataclass(frozen=True, eq=False)
class ProjectDiagnosis:
    """What was found about a project.

    Attributes
    ----------
    diagnoses : of the patches that need a cut, or were named, in the order of the project.
    rings : patches with two loops, each with a seam between them.
    not_fitted : patches that are no disk for another reason, where no cut can be tried.
    fitted : how many patches were fitted.
    """

    project: Project
    diagnoses: tuple[Diagnosis, ...]
    rings: tuple[RingSeam, ...]
    not_fitted: tuple[Finding, ...]
    fitted: int

    @property
    def all_cured(self) -> bool:
        """Whether every patch that needs a seam has one with which nothing is left that fails or wrinkles."""
        made = not any(needs_cut(ring.result) for ring in self.rings)
        wrong = [diagnosis for diagnosis in self.diagnoses if needs_cut(diagnosis.result)]
        return made and not self.not_fitted and all(diagnosis.cured for diagnosis in wrong)


def diagnose_project(
    project_file: str | Path,
    names: Collection[str] = (),
    progress: Progress = lambda *_: None,
    workers: int | None = None,
) -> ProjectDiagnosis:
    """Fit the patches of a project and try cuts on those that could not be made, or wrinkle.

    Parameters
    ----------
    names : of the patches to look at, on which cuts are tried in any case; none: all but mirror images, which are
        divided as their originals are.
    workers : how many patches are fitted at once.

    Raises
    ------
    ProjectError
        The project is invalid.
    NoSuchPatchError
        It has no patch of a given name.
    """
    project = load_project(Path(project_file))
    unknown = [name for name in names if name not in project.patches]
    if unknown:
        raise NoSuchPatchError(f"{project.file}: no patch '{unknown[0]}'; there are {', '.join(project.patches)}")
    asked = set(names or project.patches)
    surface = make_surface(project)
    network = make_network(project, surface)
    patches = [p for p in network.patches if p.name in asked and (names or p.mirror_of is None)]
    # A patch of several may need cuts, and each cut has two halves: there is use for all cores.
    with PatchFitter(project.limits, 2 * TRIALS, workers) as fitter:

        def fit_parts(name: str) -> FitAll:
            return fitter.fit_alike(project.patches[name].fitting)

        results = fitter.fit((patch, project.patches[patch.name].fitting) for patch in patches)
        diagnoses = []
        for done, (patch, result) in enumerate(zip(patches, results, strict=True), start=1):
            if names or needs_cut(result):
                progress(f"cuts of {patch.name}", done, len(patches))
                diagnoses.append(diagnose(network, patch, result, surface, fit_parts(patch.name)))
        rings = [
            ring_seam(project, network, name, surface, fit_parts(name)) for name in network.rings if name in asked
        ]
    opened = tuple(ring for ring in rings if ring is not None)
    tried = {ring.patch.name for ring in opened}
    not_fitted = tuple(finding for finding in network.failed if finding.patch in asked - tried)
    return ProjectDiagnosis(project, tuple(diagnoses), opened, not_fitted, len(patches))
