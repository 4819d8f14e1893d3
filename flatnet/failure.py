"""What can go wrong with a patch, said so that a person can act on it: findings, failures, warnings.

A `Finding` is one statement: what, on which patch, where on it, how much, what to do. A `PatchFailure`
carries one out of a fitting stage; a warning is a finding that stops nothing. Errors of a project file
are another thing: `flatnet.project.ProjectError`.
"""

from __future__ import annotations

import traceback
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from typing import Any

#: Every failure code and what it means; docs/failures.md says more about each. Those of a network that is no network
#: (`degenerate_curve`, `ambiguous_faces`) stand at the head of the messages about a project file.
CODES: dict[str, str] = {
    "degenerate_curve": "a curve has no length, a point twice or no finite number, or a boundary spans nothing",
    "open_boundary": "the curves around the patch do not close",
    "ambiguous_faces": "the faces round a node, or of a network in parts, are not told by the curves alone",
    "not_disk": "the patch is not a disk: it has several loops, or its loop winds wrongly on the surface",
    "lemma_2": "the lower bounds of the boundary angles add up to more than a planar polygon has",
    "self_intersection": "the flat outline crosses itself",
    "warp_singular": "the planar mesh could not be warped onto the boundary",
    "not_converged": "a vertex could not be made flattenable",
    "stuck_vertex": "a vertex stays far from flattenable, however the mesh is refined round it",
    "folded": "the fitted mesh folds back on itself",
    "sheet_too_small": "the piece does not fit on the material",
    "out_of_material": "there are not enough sheets or hides for all copies",
    "time_limit": "the patch took longer than it may",
    "internal_error": "a bug: the patch stopped with an error that nobody foresaw",
    "wrinkled": "the fitted mesh has wrinkles",
    "inside_surface": "the fitted mesh cuts into the reference surface",
    "off_surface": "the boundary of a mirror image leaves the reference surface",
    "normal_gap": "the sheets on both sides of a seam meet at an angle",
    "mesh_self_intersection": "the fitted mesh passes through itself in space",
    "opposed_normals": "the normals of two neighbouring edges are opposed",
    "crowded_allowance": "an allowance has no room: the piece itself or another allowance lies there",
    "deep_notch": "a notch is deeper than the allowance that it is cut into",
    "no_fold": "the piece can't be cut on the fold",
    "mark_off": "a mark lies off its patch",
    "boundary_alone": "the patch is made of its boundary alone, as its method asks",
    "ease_off": "curves that are sewn together differ in length by another ease than is declared",
    "normals_contradict": "the normals ask for curvature, which no flat piece has",
    "normals_gave_way": "the mesh is made with a lighter normal_weight than was asked for",
    "outline_opened": "the flat outline crossed itself and was opened, away from the normals",
    "no_grain": "the grain direction is nowhere along the patch",
    "divided": "the patch is a part of one that could not be made as a whole",
    "snapped_end": "an end of an imported curve was moved to the node where it meets others",
    "near_miss": "an imported curve ends near another, beyond the tolerance",
    "trimmed_end": "an imported curve ends inside a face, and that part of it was left out",
    "crossing_curves": "two imported curves cross",
    "draft_layout": "the nesting engine gave no layout: the pieces are laid plainly",
}

#: The remedy for a bug.
REPORT_IT = "This is a bug in flatnet; please report it with the project file and report.json."


@dataclass(frozen=True)
class Finding:
    """One statement about one patch.

    Attributes
    ----------
    code : a key of `CODES`.
    stage : the stage that found it: network, planar_boundary, tessellation, warp, flattenable_mesh, unfold,
        fitting (one of those, which is not known), pattern, nesting; of a finished patch, report; of a drawing, import.
    where : the place on the patch in words: curve and mm along it, vertex and coordinates; "" for all of it.
    amount : how much, in `unit`; None where there is nothing to measure.
    message : the whole statement in a sentence.
    remedy : what the user can do about it.
    """

    code: str
    stage: str
    message: str
    remedy: str
    patch: str = ""
    where: str = ""
    amount: float | None = None
    unit: str = ""
    details: str = ""

    def __post_init__(self) -> None:
        if self.code not in CODES:
            raise ValueError(f"unknown failure code {self.code!r}; known: {', '.join(sorted(CODES))}")

    def on(self, patch: str) -> Finding:
        """The same finding, with the name of its patch."""
        return replace(self, patch=patch)

    @classmethod
    def of_a_bug(cls, patch: str, stage: str, error: Exception) -> Finding:
        """The `internal_error` that an unforeseen exception is, with its traceback."""
        return cls(
            code="internal_error",
            stage=stage,
            message=f"{type(error).__name__}: {error}",
            remedy=REPORT_IT,
            patch=patch,
            details="".join(traceback.format_exception(error)),
        )

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)

    def __str__(self) -> str:
        name = f"{self.patch}: " if self.patch else ""
        return f"{name}{self.code}: {self.message} {self.remedy}".rstrip()


def spoken(point: Iterable[float]) -> str:
    """A place in space in words: (x, y, z), mm."""
    return f"({', '.join(f'{coordinate:.1f}' for coordinate in point)})"


class PatchFailure(Exception):
    """Raised by a stage where a patch can't be made; caught in one place, where one patch is run."""

    def __init__(self, finding: Finding) -> None:
        super().__init__(str(finding))
        self.finding = finding

    @classmethod
    def of(cls, code: str, stage: str, message: str, remedy: str, **rest: Any) -> PatchFailure:
        return cls(Finding(code=code, stage=stage, message=message, remedy=remedy, **rest))
