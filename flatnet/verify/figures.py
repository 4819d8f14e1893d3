"""Check that report.json says what its files show: the figures of patches and seams, its status, its list of files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from flatnet.verify.build import Findings, WrittenBuild, WrittenPatch
from flatnet.verify.measured import Measured
from flatnet.verify.mesh import WrittenMesh, corner_angles, farthest, lengths, side_lengths
from flatnet.verify.seams import WrittenSeam
from flatnet.verify.written import REPORT, DamagedError, Record, WrittenFiles

Floats = NDArray[np.float64]

HEIGHTS = "surface_distance.json"
#: Heights are written to 1e-4 mm.
HEIGHT = 1e-4
#: By how much two ways to calculate a figure may differ: angles in rad and strains, degrees, lengths in mm ...
ROUND_OFF = 1e-12
DEGREES = 1e-6
MILLIMETRES = 1e-8
#: ... and sums, relative.
SUM = 1e-9
#: What a build leaves lying about would be cut: nothing unlisted may lie here.
OURS = ("patches/*", "pieces/*", "layout-*.svg")


def check_figures(files: WrittenFiles, build: WrittenBuild, seams: Sequence[WrittenSeam], findings: Findings) -> None:
    """All figures of the report that the files tell."""
    for patch in build.patches.values():
        if not patch.mesh.faults:
            with findings.guarded():
                findings += _of_mesh(patch)
            with findings.guarded():
                findings += _of_initial(patch, files.mesh(patch.beside(".initial.obj")))
            with findings.guarded():
                findings += _of_boundary(patch, seams)
    if HEIGHTS in build.report.texts("files"):
        with findings.guarded():
            heights = Record(HEIGHTS, files.json(HEIGHTS))
            for patch in build.patches.values():
                findings += _of_heights(patch, heights)
    for seam in seams:
        with findings.guarded():
            findings += _of_seam(seam)
    with findings.guarded():
        by_name = {seam.name: seam for seam in seams}
        for walk in build.report.records("seam_walk"):
            with findings.guarded():
                findings += _of_walk(walk, by_name.get(walk.text("a")) if walk.text("a") == walk.text("b") else None)
    with findings.guarded():
        findings += _of_build(files, build)


def _figure(subject: str, key: str, said: Record, measured: float, allowed: float, unit: str = "") -> Measured:
    reported = said.number(key)
    off, words = abs(reported - measured), f"the report says {reported:.9g}, the files {measured:.9g}"
    return Measured("figures of the report", REPORT, f"{subject}, {key}", off, allowed, unit, words)


def _of_mesh(patch: WrittenPatch) -> Iterator[Measured]:
    mesh, said, name = patch.mesh, patch.metrics, patch.name
    areas = mesh.flat_areas
    smallest = np.degrees(corner_angles(side_lengths(mesh.flat, mesh.triangles)).min())
    sharpest = np.degrees(np.abs(mesh.dihedral_angles).max(initial=0.0))
    bent = _bending(mesh)
    yield _figure(name, "vertices", said, len(mesh.vertices), 0.0)
    yield _figure(name, "triangles", said, len(mesh.triangles), 0.0)
    for key, defects in (("max", mesh.defects.max(initial=0.0)), ("mean", _mean(mesh.defects))):
        yield _figure(name, f"{key}_flattenability_rad", said, defects, ROUND_OFF, "rad")
    yield _figure(name, "max_edge_strain", said, mesh.strain.max(), ROUND_OFF)
    yield _figure(name, "mean_edge_strain", said, mesh.strain.mean(), ROUND_OFF)
    yield _figure(name, "max_boundary_strain", said, mesh.boundary_strain.max(), ROUND_OFF)
    yield _figure(name, "strain_limit", said, patch.strain_limit, 0.0)
    yield _figure(name, "min_triangle_angle_deg", said, smallest, DEGREES, "deg")
    yield _figure(name, "max_dihedral_deg", said, sharpest, DEGREES, "deg")
    yield _figure(name, "bending", said, bent, SUM * max(bent, 1.0))
    yield _figure(name, "flipped_triangles", said, int((areas <= 0.0).sum()), 0.0)
    yield _figure(name, "area_mm2", said, areas.sum(), SUM * abs(areas.sum()), "mm^2")


def _mean(values: Floats) -> float:
    """Of none it is nan, as in the report."""
    return float(values.mean()) if len(values) else np.nan


def _bending(mesh: WrittenMesh) -> float:
    """Sum over the hinges of theta^2 3 l^2 / (A1 + A2)."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    length = lengths(mesh.vertices, mesh.half_edges[mesh.hinges])
    both = areas[mesh.hinges // 3] + areas[mesh.twins[mesh.hinges] // 3]
    return float(np.sum(mesh.dihedral_angles**2 * 3.0 * length**2 / both))


def _of_initial(patch: WrittenPatch, initial: WrittenMesh) -> Iterator[Measured]:
    worst = initial.defects.max(initial=0.0)
    yield _figure(patch.name, "initial_max_flattenability_rad", patch.metrics, worst, ROUND_OFF, "rad")


def _of_boundary(patch: WrittenPatch, seams: Sequence[WrittenSeam]) -> Iterator[Measured]:
    """Distance from the curves, and angles to their normals."""
    mesh = patch.mesh
    normal_at = {
        frozenset(pair): mesh.normals[edge // 3]
        for edge in np.flatnonzero(mesh.twins < 0).tolist()
        for pair in [mesh.half_edges[edge].tolist()]
    }
    away, deviations = [0.0], []
    for seam in seams:
        for side in seam.sides:
            if side.patch is not patch:
                continue
            away.append(farthest(mesh.vertices[side.vertices], seam.curve.vertices))
            own = np.array([normal_at[frozenset(pair)] for pair in side.pairs.tolist()])
            given = seam.curve.right_normals if side.reversed else seam.curve.left_normals
            deviations.append(2.0 * np.arctan2(*(np.linalg.norm(own - s * given, axis=1) for s in (1.0, -1.0))))
    yield _figure(patch.name, "boundary_error_mm", patch.metrics, max(away), MILLIMETRES, "mm")
    if deviations:
        degrees = np.degrees(np.concatenate(deviations))
        yield _figure(patch.name, "max_normal_deviation_deg", patch.metrics, degrees.max(), DEGREES, "deg")
        yield _figure(patch.name, "mean_normal_deviation_deg", patch.metrics, degrees.mean(), DEGREES, "deg")


def _of_heights(patch: WrittenPatch, heights: Record) -> Iterator[Measured]:
    values = heights.numbers(patch.name)
    if len(values) != len(patch.mesh.vertices):
        count = len(patch.mesh.vertices)
        raise DamagedError(HEIGHTS, f"'{patch.name}' has {len(values)} heights, and {count} vertices")
    said = patch.metrics.record("surface_distance_mm")
    for key, measured in (
        ("mean", np.abs(values).mean()),
        ("max", np.abs(values).max()),
        ("max_outside", values.max(initial=0.0)),
        ("max_inside", (-values).max(initial=0.0)),
    ):
        yield _figure(f"{patch.name}, surface_distance_mm", key, said, measured, HEIGHT, "mm")


def _of_seam(seam: WrittenSeam) -> Iterator[Measured]:
    said, name = seam.record, f"seam '{seam.name}'"
    yield _figure(name, "length_3d_mm", said, float(seam.steps.sum()), MILLIMETRES, "mm")
    names = [record.text("patch") for record in said.records("sides")]
    words = f"it names {', '.join(said.texts('patches'))}"
    others = float(said.texts("patches") != names)
    yield Measured("figures of the report", REPORT, f"{name}, patches", others, 0.0, words=words)
    along = {side.key: side.arclengths for side in seam.sides}
    for key, flat in along.items():
        yield _figure(name, f"length_{key}_mm", said, flat[-1], MILLIMETRES, "mm")
    if len(along) == 2:
        yield _figure(name, "difference_mm", said, abs(along["a"][-1] - along["b"][-1]), MILLIMETRES, "mm")
    space = np.concatenate([[0.0], np.cumsum(seam.steps)])
    for number, notch in enumerate(said.records("notches"), start=1):
        at = notch.number("at_3d_mm")
        for key, flat in along.items():
            met = float(np.interp(at, space, flat))
            yield _figure(f"{name}, notch {number}", f"at_{key}_mm", notch, met, MILLIMETRES, "mm")


def _of_walk(walk: Record, seam: WrittenSeam | None) -> Iterator[Measured]:
    """Its legs add up; along one seam they are those between its notches."""
    name = f"walk along '{walk.text('a')}'"
    legs = walk.records("legs")
    for key in ("a", "b"):
        along = np.cumsum([leg.number(f"{key}_mm") for leg in legs])
        yield _figure(name, f"length_{key}_mm", walk, float(along[-1]) if len(along) else np.nan, MILLIMETRES, "mm")
        flat = [side.arclengths[-1] for side in seam.sides if side.key == key] if seam else []
        if seam and flat:
            stops = [*(notch.number(f"at_{key}_mm") for notch in seam.record.records("notches")), *flat]
            off = float(np.abs(along - stops).max()) if len(along) == len(stops) else np.nan
            words = "its legs do not end at the notches"
            yield Measured("figures of the report", REPORT, f"{name}, {key}", off, MILLIMETRES, "mm", words)
    ease = walk.number("length_a_mm") - walk.number("length_b_mm")
    yield _figure(name, "ease_mm", walk, ease, MILLIMETRES, "mm")


def _of_build(files: WrittenFiles, build: WrittenBuild) -> Iterator[Measured]:
    """The status, and that the folder holds what is listed; nothing else that would be cut."""
    report = build.report
    made = [record.text("status") == "ok" for record in report.records("patches")]
    laid = bool(report.records("layouts"))
    status = "failed" if not laid or not any(made) else "ok" if all(made) else "partial"
    words = f"the report says '{report.text('status')}', its patches and layouts '{status}'"
    yield Measured("status of the report", REPORT, "", float(status != report.text("status")), 0.0, words=words)
    listed = set(report.texts("files"))
    for name in sorted(listed):
        try:
            files.content(name)
            words = ""
        except DamagedError as error:
            words = error.words
        yield Measured("files of the report", name, "", float(bool(words)), 0.0, words=words)
    named = {REPORT, *(piece.file for piece in build.pieces)}
    named |= {record.text("file") for record in report.records("layouts")}
    for patch in build.patches.values():
        named |= {patch.file, patch.beside(".initial.obj"), patch.beside(".folds.json")}
    for name in sorted(named - listed):
        yield Measured("files of the report", name, "", 1.0, 0.0, words="belongs to the build and is not listed")
    found = {path.relative_to(files.folder).as_posix() for pattern in OURS for path in files.folder.glob(pattern)}
    for name in sorted(found - listed):
        yield Measured("nothing unlisted", name, "", 1.0, 0.0, words="is of no build, and might be cut")
    yield Measured("nothing unlisted", REPORT, "files", 0.0, 0.0)
