"""The whole flow on one page: a project file in, a folder of pieces, layouts and a report out."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flatnet.export.file_names import safe_file_names
from flatnet.export.folds import write_folds
from flatnet.export.formats import EXPORTS, export, require_libraries
from flatnet.export.network_json import write_network
from flatnet.export.obj import write_obj
from flatnet.export.output import HEIGHTS, REPORT, OutputFolder
from flatnet.export.pieces_json import PIECES, PieceFile, write_pieces
from flatnet.export.svg import write_layout, write_piece
from flatnet.failure import Finding, PatchFailure
from flatnet.fitting.mirror import reflect_patch
from flatnet.fitting.results import FailedPatch, FittedPatch
from flatnet.fitting.run import run_patch
from flatnet.forms import ReferenceSurface, make_surface
from flatnet.forms.distance import signed_distance
from flatnet.geometry.mirror import MirrorPlane, lies_on_one_side
from flatnet.nesting.layout import Layout
from flatnet.nesting.nest import nest
from flatnet.nesting.stored import Stored, read_stored, write_stored
from flatnet.network import CurveNetwork
from flatnet.network.assembly import make_network
from flatnet.patch_fitter import Fit, PatchFitter
from flatnet.pattern.on_fold import half_on_fold
from flatnet.pattern.piece import Piece, make_piece
from flatnet.pattern.seams import Seam, plan_seams
from flatnet.project import Project, load_project
from flatnet.remedies.auto_split import auto_split
from flatnet.remedies.diagnose import FitAll
from flatnet.report.report import make_report

#: Called as the work goes on: what is being done, how many of the patches are done, of how many.
Progress = Callable[[str, int, int], None]

STORED_LAYOUT = "layout.json"


@dataclass(frozen=True, eq=False)
class BuildResult:
    """What a build came to; `report` is the content of report.json in `folder`."""

    folder: Path
    report: dict[str, object] = field(repr=False)  # tens of kilobytes

    @property
    def exit_status(self) -> int:
        """0: all patches made and laid out; 1: some, or none."""
        return 0 if self.report["status"] == "ok" else 1


def build(
    project_file: str | Path,
    out: str | Path,
    progress: Progress = lambda *_: None,
    workers: int | None = None,
    fit: Fit = run_patch,
    split: bool = False,
    nest_again: bool = False,
    final: bool = False,
) -> BuildResult:
    """Fit every patch of a project, lay the pieces out and write everything to the folder `out`.

    Parameters
    ----------
    workers : how many patches are fitted at once, each in a process of its own; by default one for each core
        that may be used. Only the time depends on it.
    fit : what fits a patch.
    split : divide patches that can't be made, or wrinkle, by the best cut that is found (`auto_split`).
    nest_again : do not use the layouts that an earlier build left in `out`.
    final : give the nesting engine as long as for the layouts that are cut (`NestingParameters.final`).

    Raises
    ------
    ProjectError
        The project is invalid; nothing is written.
    OutputError
        The folder can't be used or written; the earlier build in it is as it was.
    ExportError
        A format that the project asks for needs a library that is not installed.
    ValueError
        `workers` is less than 1.
    """
    if workers is not None and workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers}")
    project = load_project(Path(project_file))
    if final:
        project = replace(project, nesting=project.nesting.final())
    require_libraries(project.exports)
    # They start, which takes a second, while the network is made.
    with PatchFitter(project.limits, len(project.patches), workers, fit) as fitter:
        surface = make_surface(project)
        network = make_network(project, surface)
        seams = plan_seams(project, network)
        with OutputFolder(Path(out)) as output:
            results = _fit_all(project, network, fitter, progress)
            if split:
                project, network, results = _split(project, network, surface, results, fitter, progress)
                seams = plan_seams(project, network)
            fitter.dismiss()
            pieces, halves, results = _make_pieces(project, seams, results)
            stored = {} if nest_again else read_stored(output.previous(STORED_LAYOUT))
            layouts, unlaid = _nest_all(project, pieces, stored, progress)
            named = dict(zip(layout_files(layouts), layouts, strict=True))
            heights = _heights(results, surface, project.mirror)
            files = [*_write(output.staging, project, network, results, heights, pieces, halves, named), REPORT]
            findings = [*project.findings, *unlaid]
            report = make_report(
                project.name, network, seams, heights, project.clearance, results, named, findings, sorted(files)
            )
            (output.staging / REPORT).write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
            if project.exports and pieces:
                exported = export(output.staging, project.exports)
                files += [f"{EXPORTS}/{name}" for name in exported.files]
                report |= {"files": sorted(files), "export_notes": exported.notes}
                (output.staging / REPORT).write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
            output.commit(files)
    return BuildResult(output.folder, report)


def check(project_file: str | Path) -> tuple[Project, CurveNetwork]:
    """Read a project, sample its network and find its faces, without fitting.

    Raises
    ------
    ProjectError
        The project is invalid.
    """
    project = load_project(Path(project_file))
    network = make_network(project, make_surface(project))
    plan_seams(project, network)  # notches beyond a curve's end
    return project, network


def _fit_all(
    project: Project, network: CurveNetwork, fitter: PatchFitter, progress: Progress
) -> list[FittedPatch | FailedPatch]:
    """Every patch of the project in its order."""
    results: dict[str, FittedPatch | FailedPatch] = {}

    def note(name: str, result: FittedPatch | FailedPatch) -> None:
        results[name] = result
        progress(name, len(results), len(project.patches))

    for finding in network.failed:
        note(finding.patch, FailedPatch(finding.patch, finding))
    originals = [patch for patch in network.patches if patch.mirror_of is None]
    fitter.fit(((patch, project.patches[patch.name].fitting) for patch in originals), note)
    for patch in network.patches:
        if patch.mirror_of is not None:
            assert project.mirror is not None, "a project with mirror images has a plane"
            note(patch.name, reflect_patch(results[patch.mirror_of], patch, project.mirror))
    return [results[name] for name in project.patches]


def _split(
    project: Project,
    network: CurveNetwork,
    surface: ReferenceSurface | None,
    results: Sequence[FittedPatch | FailedPatch],
    fitter: PatchFitter,
    progress: Progress,
) -> tuple[Project, CurveNetwork, list[FittedPatch | FailedPatch]]:
    """The project with what could not be made in parts."""

    def fit_all(name: str) -> FitAll:
        progress(f"cuts of {name}", len(results), len(project.patches))
        return fitter.fit_alike(project.patches[name].fitting)

    by_name = dict(zip(project.patches, results, strict=True))
    project, network, made = auto_split(project, network, by_name, surface, fit_all)
    return project, network, list(made.values())


def _nest_all(
    project: Project, pieces: Sequence[Piece], stored: Stored, progress: Progress
) -> tuple[list[Layout], list[Finding]]:
    """The sheets of every material, in the order of the project."""
    layouts: list[Layout] = []
    findings: list[Finding] = []
    count = len(project.patches)
    for material in project.materials.values():
        of_material = [piece for piece in pieces if piece.material == material.name]
        done, found = nest(
            of_material, material, project.nesting, stored, lambda text: progress(text, count, count)
        )
        layouts += done
        findings += found
    return layouts, findings


def _make_pieces(
    project: Project, seams: Mapping[str, Seam], results: Sequence[FittedPatch | FailedPatch]
) -> tuple[list[Piece], dict[str, Piece], list[FittedPatch | FailedPatch]]:
    """A piece for every fitted patch; one whose piece can't be made becomes a failed patch.

    Returns
    -------
    pieces, halves : those that are cut on the fold also as halves, by their titles.
    kept : the results, in their order.
    """
    pieces: list[Piece] = []
    halves: dict[str, Piece] = {}
    kept: list[FittedPatch | FailedPatch] = []
    for result in results:
        if isinstance(result, FittedPatch):
            name = result.patch.name
            try:
                made = _pieces_of(project, seams, result)
                halves |= {_title(project, piece): half_on_fold(piece, piece.fold) for piece in made if piece.fold}
                pieces += made
                warnings = dict.fromkeys(warning for piece in made for warning in piece.warnings)
                result = replace(result, warnings=(*result.warnings, *warnings))
            except PatchFailure as failure:
                result = FailedPatch(name, failure.finding.on(name), result.warnings, result.seconds)
            except Exception as error:
                bug = Finding.of_a_bug(name, "pattern", error)
                result = FailedPatch(name, bug, result.warnings, result.seconds)
        kept.append(result)
    return pieces, halves, kept


def _pieces_of(project: Project, seams: Mapping[str, Seam], fitted: FittedPatch) -> list[Piece]:
    """One piece of a patch for each material that it is cut from."""
    spec = project.patches[fitted.patch.name]
    made = [
        make_piece(fitted, project.materials[material], seams, project.title, also, spec.marks)
        for material, also in zip(spec.materials, (None, *spec.also), strict=True)
    ]
    # Of a further material no zone is asked.
    return [
        replace(piece, zone=spec.zone if piece.material == spec.material else "", match=spec.match) for piece in made
    ]


def _heights(
    results: Sequence[FittedPatch | FailedPatch], surface: ReferenceSurface | None, mirror: MirrorPlane | None
) -> dict[str, NDArray[np.float64]]:
    """Of every fitted patch, how far its vertices lie outside the reference surface, mm; none without one.

    A surface that ends at the mirror plane stands for both halves.
    """
    if surface is None:
        return {}
    halved = mirror is not None and lies_on_one_side(surface.mesh.vertices, mirror)
    heights = {}
    for result in results:
        if isinstance(result, FittedPatch):
            vertices = result.mesh.vertices
            if halved and mirror is not None and result.patch.mirror_of is not None:
                vertices = mirror.reflect(vertices)
            heights[result.patch.name] = signed_distance(surface, vertices)
    return heights


def layout_files(layouts: Sequence[Layout]) -> list[str]:
    """A file name for every sheet, distinct whatever the materials are called."""
    titles = [
        f"layout-{layout.material.name}" + (f"-{layout.sheet}" if layout.sheet > 1 else "") for layout in layouts
    ]
    # Materials may be called denim and denim-2: then their sheets' titles can be equal.
    unique = [f"{title}{' ' * titles[:i].count(title)}" for i, title in enumerate(titles)]
    safe = safe_file_names(unique)
    return [f"{safe[title]}.svg" for title in unique]


def _titles(project: Project) -> list[str]:
    """Every patch, every piece of one that is cut from a further material, their halves; a blank is in no name."""
    specs = project.patches.values()
    whole = dict(project.patches) | {f"{spec.name} {also.material}": spec for spec in specs for also in spec.also}
    return [*whole, *(f"{title} on fold" for title, spec in whole.items() if spec.fold)]


def _title(project: Project, piece: Piece) -> str:
    of_patch = piece.material == project.patches[piece.name].material
    return piece.name if of_patch else f"{piece.name} {piece.material}"


def _write(
    folder: Path,
    project: Project,
    network: CurveNetwork,
    results: Sequence[FittedPatch | FailedPatch],
    heights: Mapping[str, NDArray[np.float64]],
    pieces: Sequence[Piece],
    halves: Mapping[str, Piece],
    layouts: dict[str, Layout],
) -> list[str]:
    """Write all files but the report into a folder; their names relative to it."""
    (folder / "patches").mkdir()
    (folder / "pieces").mkdir()
    names = safe_file_names(_titles(project))
    files = ["network.json", PIECES, STORED_LAYOUT, *layouts]
    write_network(folder / "network.json", network)
    named = {names[_title(project, piece)]: piece for piece in pieces}
    write_pieces(folder / PIECES, PieceFile(project.name, project.size, project.materials, named, project.strokes))
    write_stored(folder / STORED_LAYOUT, layouts.values())
    if heights:
        files.append(HEIGHTS)
        rounded = {name: values.round(4).tolist() for name, values in heights.items()}
        (folder / HEIGHTS).write_text(json.dumps(rounded) + "\n", encoding="utf-8")
    for result in results:
        if isinstance(result, FittedPatch):
            name = names[result.patch.name]
            mesh, warped = result.mesh, result.warped
            files += [f"patches/{name}.obj", f"patches/{name}.initial.obj", f"patches/{name}.folds.json"]
            write_obj(folder / files[-3], mesh.vertices, mesh.triangles, result.flat)
            write_obj(folder / files[-2], warped.vertices, warped.triangles, result.planar.positions)
            write_folds(folder / files[-1], mesh)
    drawn = named | {names[f"{title} on fold"]: half for title, half in halves.items()}
    for name, piece in drawn.items():
        files.append(f"pieces/{name}.svg")
        write_piece(folder / files[-1], piece, project.strokes)
    for file, layout in layouts.items():
        wanted = [spec.name for spec in project.patches.values() if layout.material.name in spec.materials]
        sheets = [other for other in layouts.values() if other.material.name == layout.material.name]
        laid = {p.piece.name for other in sheets for p in other.placements}
        missing = [name for name in wanted if name not in laid]
        write_layout(folder / file, layout, project.title, missing, project.strokes)
    return files
