"""The flow of `flatnet verify`: a folder of a build in, what was measured on its files out."""

from __future__ import annotations

from pathlib import Path

from flatnet.verify.build import NETWORK, Findings, WrittenBuild, read_build
from flatnet.verify.certificate import Certificate
from flatnet.verify.exports import check_exports
from flatnet.verify.figures import check_figures
from flatnet.verify.layouts import check_layouts
from flatnet.verify.patches import check_patch
from flatnet.verify.round_trip import check_folds, check_round_trip, read_folds
from flatnet.verify.seams import WrittenSeam, check_notches, check_seams, read_seams
from flatnet.verify.written import REPORT, REPORT_FORMAT, NotABuildError, Record, WrittenFiles


def verify(out: str | Path) -> Certificate:
    """Check a build from its written files alone and write certificate.json beside them.

    Raises
    ------
    NotABuildError
        The folder holds no report of a build, or can't be written; nothing is written.
    """
    folder = Path(out)
    files, findings = WrittenFiles(folder), Findings()
    if not folder.is_dir():
        raise NotABuildError(f"{folder}: is no folder; name the output folder of a build")
    if not (folder / REPORT).is_file():
        raise NotABuildError(f"{folder}: holds no {REPORT} of a build; run `flatnet build` into it first")
    project = ""
    with findings.guarded():
        if REPORT_FORMAT not in files.text(REPORT):
            raise NotABuildError(f"{folder / REPORT}: is no report of the format '{REPORT_FORMAT}'; build again")
        report = Record(REPORT, files.json(REPORT))
        if not report.lists("patches") and NETWORK not in report.texts("files"):
            raise NotABuildError(
                f"{folder}: is a layout that `flatnet nest` made, and this checks builds: verify those that it was "
                "made of (each layout was checked when it was made); nothing was written"
            )
        project = report.text("project")
        _check(files, report, findings)
    certificate = Certificate(project, tuple(findings), files.hashes)
    certificate.write(folder)
    return certificate


def _check(files: WrittenFiles, report: Record, findings: Findings) -> None:
    build = read_build(files, report, findings)
    for patch in build.patches.values():
        findings += check_patch(patch)
    seams = read_seams(build, findings)
    findings += check_seams(build, seams)
    check_notches(build, seams, findings)
    _check_round_trips(files, build, seams, findings)
    check_layouts(files, build, findings)
    check_exports(files, build, findings)
    check_figures(files, build, seams, findings)


def _check_round_trips(
    files: WrittenFiles, build: WrittenBuild, seams: list[WrittenSeam], findings: Findings
) -> None:
    """Every patch that is exact is folded again; where the material gives, the flat piece is not the mesh unfolded."""
    for patch in build.patches.values():
        if patch.mesh.faults:
            continue
        sides = [(seam, side) for seam in seams for side in seam.sides if side.patch is patch]
        places = {
            vertex: place
            for seam, side in sides
            for vertex, place in zip(side.vertices.tolist(), seam.curve.vertices, strict=True)
        }
        with findings.guarded():
            angles = read_folds(files, patch)
            findings.append(check_folds(patch, angles))
            if patch.strain_limit == 0.0 and places:
                findings += check_round_trip(patch, angles, places)
