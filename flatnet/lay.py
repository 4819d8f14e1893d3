"""Pieces of builds that were written, or of a published nesting problem, in; one folder of layouts out."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from pathlib import Path

import numpy as np

from flatnet.build import STORED_LAYOUT, BuildResult, Progress, layout_files
from flatnet.export.file_names import safe_file_names
from flatnet.export.output import REPORT, REPORT_FORMAT, OutputFolder, read_of_build
from flatnet.export.pieces_json import PIECES, PieceFile, read_pieces, write_pieces
from flatnet.export.svg import write_layout
from flatnet.failure import Finding
from flatnet.nesting.instance import read_instance
from flatnet.nesting.layout import Layout
from flatnet.nesting.nest import nest
from flatnet.nesting.stored import read_stored, write_stored
from flatnet.parameters import NestingParameters
from flatnet.pattern.piece import Piece
from flatnet.project.loader import load_materials
from flatnet.project.model import Material
from flatnet.report.report import layout_record, status
from flatnet.version import VERSION


class LayError(Exception):
    """What was named can't be laid together; the message says why."""


def lay(
    sources: Sequence[str | Path],
    out: str | Path,
    parameters: NestingParameters,
    progress: Progress = lambda *_: None,
    again: bool = False,
    materials_file: str | Path | None = None,
) -> BuildResult:
    """Lay the pieces of all sources out, those of one material together, and write the layouts to the folder `out`.

    Parameters
    ----------
    sources : output folders of builds; or one file with a strip packing problem (JSON).
    again : do not use the layouts that an earlier run left in `out`.
    materials_file : YAML with `materials`, which take the place of those of the same name.

    Raises
    ------
    ProjectError
        The file of materials is invalid.
    LayError, InstanceError
        A source holds no pieces, or is `out` itself, whose patches would be gone; two of them have different materials
        of one name, or a piece asks for a zone that its material does not have; nothing is written.
    OutputError
        The folder can't be used or written.
    """
    if any(Path(source).resolve() == Path(out).resolve() for source in sources):
        raise LayError(f"{out}: is laid itself, and layouts take the place of all that is in it; name another folder")
    others = {} if materials_file is None else load_materials(materials_file)
    title, pieces, materials, unmade = _read([Path(source) for source in sources], others)
    layouts: list[Layout] = []
    findings = list(unmade)
    with OutputFolder(Path(out)) as output:
        stored = {} if again else read_stored(output.previous(STORED_LAYOUT))
        for done, material in enumerate(materials):
            of_material = [piece for piece in pieces if piece.material == material.name]
            told = partial(_told, progress, done, len(materials))
            made, found = nest(of_material, material, parameters, stored, told)
            layouts += made
            findings += found
        named = dict(zip(layout_files(layouts), layouts, strict=True))
        missing = {finding.patch for finding in findings if finding.patch}
        for file, layout in named.items():
            wanted = [piece.name for piece in pieces if piece.material == layout.material.name]
            # What was not made says no more what it would have been cut from: all sheets name it.
            absent = [*(finding.patch for finding in unmade), *(name for name in wanted if name in missing)]
            write_layout(output.staging / file, layout, title, absent)
        write_stored(output.staging / STORED_LAYOUT, layouts)
        write_pieces(output.staging / PIECES, _piece_file(title, pieces, materials))
        files = sorted([*named, PIECES, STORED_LAYOUT, REPORT])
        report = _report(title, pieces, named, findings, files)
        (output.staging / REPORT).write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
        output.commit(files)
    return BuildResult(output.folder, report)


def _piece_file(title: str, pieces: Sequence[Piece], materials: Sequence[Material]) -> PieceFile:
    """All pieces for `flatnet export`; one that is cut from a second material has that in its file's name."""
    names: list[str] = []
    for piece in pieces:
        names.append(f"{piece.name} {piece.material}" if piece.name in names else piece.name)
    safe = safe_file_names(names)
    named = {safe[name]: piece for name, piece in zip(names, pieces, strict=True)}
    return PieceFile(title, "", {material.name: material for material in materials}, named)


def _told(progress: Progress, done: int, total: int, text: str) -> None:
    progress(text, done, total)


def _report(
    title: str,
    pieces: Sequence[Piece],
    layouts: dict[str, Layout],
    findings: Sequence[Finding],
    files: Sequence[str],
) -> dict[str, object]:
    """As a build's, of layouts alone."""
    not_laid = {finding.patch for finding in findings if finding.patch}
    names = dict.fromkeys([*(piece.name for piece in pieces), *not_laid])
    return {
        "format": REPORT_FORMAT,
        "flatnet": VERSION,
        "project": title,
        "status": status([name not in not_laid for name in names], bool(layouts)),
        "patches": [],
        "seams": [],
        "layouts": [layout_record(file, layout) for file, layout in layouts.items()],
        "findings": [finding.as_dict() for finding in findings],
        "files": list(files),
    }


def _read(
    sources: Sequence[Path], others: Mapping[str, Material]
) -> tuple[str, list[Piece], list[Material], list[Finding]]:
    """Title, pieces of distinct names, their materials, in whose place others may be, and what was not made."""
    unmade: list[Finding] = []
    if len(sources) == 1 and not sources[0].is_dir():
        pieces, material = read_instance(sources[0])
        title, materials = material.name, {material.name: others.get(material.name, material)}
    else:
        title, pieces, materials, unmade = _read_builds(sources, others)
    unknown = [name for name in others if name not in materials]
    if unknown:
        used = ", ".join(map(repr, materials))
        raise LayError(f"no piece is cut from material {unknown[0]!r}; the pieces' materials are {used}")
    return title, pieces, list(materials.values()), unmade


def _read_builds(
    sources: Sequence[Path], others: Mapping[str, Material]
) -> tuple[str, list[Piece], dict[str, Material], list[Finding]]:
    """The same of builds, the materials by name."""
    builds = [_read_build(source) for source in sources]
    builds = [replace(build, materials={**build.materials, **others}) for build in builds]
    materials = _materials_of(sources, builds)
    titles = [build.title for build in builds]
    prefixes = [title if titles.count(title) == 1 else f"{title} {at}" for at, title in enumerate(titles, 1)]
    names = ["" if len(builds) == 1 else f"{prefix}: " for prefix in prefixes]
    pieces = [
        _prefixed(piece, name)
        for name, build in zip(names, builds)
        for piece in build.pieces.values()
    ]
    unmade = [
        replace(finding, patch=f"{name}{finding.patch}")
        for name, source, build in zip(names, sources, builds)
        for finding in _unmade(source, build)
    ]
    return " + ".join(dict.fromkeys(titles)), pieces, materials, unmade


def _unmade(folder: Path, build: PieceFile) -> list[Finding]:
    """Why patches could not be made of which the report of a build tells, and which have no piece."""
    file = folder / REPORT
    made = {piece.name for piece in build.pieces.values()}
    if not file.is_file():  # its pieces alone are laid as they are
        return []
    try:
        records = json.loads(file.read_text(encoding="utf-8"))["patches"]
        return [
            Finding(**record["failure"]).on(record["name"])
            for record in records
            if record["failure"] and record["name"] not in made
        ]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise LayError(f"{file}: not the report of a build: {type(error).__name__}: {error}; build again") from None


def _prefixed(piece: Piece, prefix: str) -> Piece:
    """A piece and its seams with a prefix before their names: those of two builds are told apart."""

    def prefixed(name: str) -> str:
        return f"{prefix}{name}"

    runs = tuple(
        replace(
            run,
            seam=replace(run.seam, name=prefixed(run.seam.name), patches=tuple(map(prefixed, run.seam.patches))),
        )
        for run in piece.seams
    )
    return replace(
        piece,
        name=prefixed(piece.name),
        seams=runs,
        notches=tuple(replace(notch, seam=prefixed(notch.seam)) for notch in piece.notches),
        nicks=tuple(replace(nick, seam=prefixed(nick.seam)) for nick in piece.nicks),
    )


def _materials_of(sources: Sequence[Path], builds: Sequence[PieceFile]) -> dict[str, Material]:
    """The materials that pieces are cut from, by name; those of one name are alike, and have the zones asked for."""
    materials: dict[str, Material] = {}
    said_in: dict[str, Path] = {}
    for source, build in zip(sources, builds):
        for name in dict.fromkeys(piece.material for piece in build.pieces.values()):
            known, first = materials.setdefault(name, build.materials[name]), said_in.setdefault(name, source)
            if known != build.materials[name]:
                raise LayError(
                    f"{source}: its material '{name}' is another than that of {first}: "
                    f"{_differences(build.materials[name], known)}; say what they are laid on with `--materials FILE`, "
                    "whose materials take the place of those of the same name"
                )
        for piece in build.pieces.values():
            if piece.zone and piece.zone not in materials[piece.material].zones:
                raise LayError(
                    f"{build.title}: piece '{piece.name}' asks for zone '{piece.zone}', which no hide of material "
                    f"'{piece.material}' has"
                )
    return materials


def _differences(one: Material, other: Material) -> str:
    """The keys in which two materials differ, with both values."""
    return ", ".join(
        f"{field.name} {_spoken(field.name, getattr(one, field.name))} and not "
        f"{_spoken(field.name, getattr(other, field.name))}"
        for field in fields(Material)
        if getattr(one, field.name) != getattr(other, field.name)
    )


def _spoken(key: str, value: object) -> str:
    """A value of a material as its file would say it, lengths in mm; of hides only how many, and how large."""
    if key == "rotations":
        return "free" if value is None else str(list(value)) if isinstance(value, tuple) else str(value)
    if key == "hides" and isinstance(value, tuple):
        sizes = (np.ptp(hide.outline, axis=0) for hide in value)
        return "[" + ", ".join(f"{length:g} x {width:g} mm" for length, width in sizes) + "]"
    if key in ("width", "length", "gap", "allowance", "thickness") and value is not None:
        return f"{value:g} mm"
    return "none" if value is None else f"{value:g}"


def _read_build(folder: Path) -> PieceFile:
    return read_of_build(folder / PIECES, read_pieces, LayError, "name the output folder of a build")
