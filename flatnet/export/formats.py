"""The formats of `flatnet export`: what each writes, and the one function that writes some of them into a folder."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from flatnet.export.dxf import write_dxf
from flatnet.export.dxf_pattern import AAMA, ASTM, Dialect, write_dxf_pattern
from flatnet.export.file_names import safe_file_names
from flatnet.export.garmentcode import write_garmentcode
from flatnet.export.hpgl import write_hpgl
from flatnet.export.lists import write_cut_list, write_material_list
from flatnet.export.missing_library import needs
from flatnet.export.model_3d import write_model_glb, write_model_obj, write_model_ply
from flatnet.export.output import CERTIFICATE, REPORT
from flatnet.export.pdf import PAPERS, Pages, draw_certificate, draw_full_size, draw_tiles
from flatnet.export.sewing import write_sewing
from flatnet.export.svg import seam_table, write_layout, write_piece
from flatnet.export.written_build import ExportError, Sheet, WrittenBuild, read_written

#: Folder inside a build's that exports go to where no other is named.
EXPORTS = "exports"


@dataclass
class Exported:
    """What was written: files, relative to their folder, and notes for whoever uses them."""

    files: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


#: Writes one format of a build into a folder.
Exporter = Callable[[WrittenBuild, Path, Exported], None]


def _svg(build: WrittenBuild, folder: Path, done: Exported) -> None:
    strokes = build.content.strokes
    for sheet in build.sheets:
        path = folder / _new(done, f"{sheet.name}.svg")
        write_layout(path, sheet.layout, build.content.title, build.missing, strokes, by_meaning=True)
    (folder / "pieces").mkdir()
    for name, piece in build.pieces.items():
        write_piece(folder / _new(done, f"pieces/{name}.svg"), piece, strokes, by_meaning=True)


def _dxf(build: WrittenBuild, folder: Path, done: Exported) -> None:
    for sheet in build.sheets:
        write_dxf(folder / _new(done, f"{sheet.name}.dxf"), sheet.layout, title(build, sheet), build.content.strokes)


def _dxf_pattern(dialect: Dialect) -> Exporter:
    def exporter(build: WrittenBuild, folder: Path, done: Exported) -> None:
        name = _new(done, f"pattern-{dialect.name.lower()}.dxf")
        done.notes += write_dxf_pattern(folder / name, build.content, dialect)

    return exporter


def _pdf(paper: str) -> Exporter:
    def exporter(build: WrittenBuild, folder: Path, done: Exported) -> None:
        ending = f"-{paper}" if paper else ""
        for sheet in build.sheets:
            name = _new(done, f"{sheet.name}{ending}.pdf")
            pages = Pages(folder / name, title(build, sheet), build.content.strokes)
            rows = seam_table(sheet.layout.placements)
            if paper:
                draw_tiles(pages, sheet.layout, title(build, sheet), rows, PAPERS[paper])
            else:
                draw_full_size(pages, sheet.layout, title(build, sheet), rows)
            if build.certificate is not None:
                draw_certificate(pages, build.certificate, PAPERS[paper or "a4"])
            done.notes += [f"{name}: {note}" for note in pages.save()]

    return exporter


def _hpgl(build: WrittenBuild, folder: Path, done: Exported) -> None:
    for sheet in build.sheets:
        done.notes += write_hpgl(folder / _new(done, f"{sheet.name}.plt"), sheet.layout)


def _model(ending: str, write: Callable[[Path, WrittenBuild], None]) -> Exporter:
    def exporter(build: WrittenBuild, folder: Path, done: Exported) -> None:
        write(folder / _new(done, f"model.{ending}"), build)

    return exporter


def _garmentcode(build: WrittenBuild, folder: Path, done: Exported) -> None:
    (name,) = safe_file_names([build.content.project]).values()
    write_garmentcode(folder / _new(done, f"{name}_specification.json"), build)


def _sewing(build: WrittenBuild, folder: Path, done: Exported) -> None:
    write_sewing(folder / _new(done, "sewing.json"), build)


def _lists(build: WrittenBuild, folder: Path, done: Exported) -> None:
    write_cut_list(folder / _new(done, "cut-list.csv"), build)
    write_material_list(folder / _new(done, "materials.csv"), build)


#: Format -> what writes it.
EXPORTERS: dict[str, Exporter] = {
    "svg": _svg,
    "dxf": _dxf,
    "dxf-astm": _dxf_pattern(ASTM),
    "dxf-aama": _dxf_pattern(AAMA),
    "pdf": _pdf(""),
    **{f"pdf-{paper}": _pdf(paper) for paper in PAPERS},
    "hpgl": _hpgl,
    "obj": _model("obj", write_model_obj),
    "glb": _model("glb", write_model_glb),
    "ply": _model("ply", write_model_ply),
    "sewing": _sewing,
    "garmentcode": _garmentcode,
    "cutlist": _lists,
}


#: Formats that are made of meshes, or of the seams between patches: a layout of several builds has neither.
OF_BUILDS = ("obj", "glb", "ply", "sewing", "garmentcode")

#: Format -> modules that it needs beyond those that every installation has.
LIBRARIES = {
    "dxf": ("ezdxf",),
    "dxf-astm": ("ezdxf", "anyascii"),
    "dxf-aama": ("ezdxf", "anyascii"),
    "pdf": ("reportlab", "anyascii"),
    **{f"pdf-{paper}": ("reportlab", "anyascii") for paper in PAPERS},
    "hpgl": ("anyascii",),
    "glb": ("pygltflib",),
}


def require_libraries(formats: Sequence[str]) -> None:
    """See that all libraries for some formats are there.

    Raises
    ------
    ExportError
        One is missing; says how to install it.
    """
    for name in formats:
        for module in LIBRARIES.get(name, ()):
            needs(module, f"the format {name!r}")


def title(build: WrittenBuild, sheet: Sheet) -> str:
    """What a sheet is, in one line."""
    parts = [build.content.title, sheet.layout.name, sheet.layout.title_size]
    if build.missing:
        parts.append(f"INCOMPLETE: missing {', '.join(build.missing)}")
    return " · ".join(parts)


def _new(done: Exported, name: str) -> str:
    done.files.append(name)
    return name


def write_exports(folder: Path, formats: Sequence[str], target: Path, certificate: bool = False) -> Exported:
    """Write formats of the build in `folder` into `target`; PDFs with the certificate where it is asked for.

    Raises
    ------
    ExportError
        There is no whole build in the folder, or a library is missing.
    """
    require_libraries(formats)
    build = read_written(folder, certificate)
    refused = [name for name in formats if build.is_layout and name in OF_BUILDS]
    if refused:
        raise ExportError(
            f"{folder}: is a layout that `flatnet nest` made, of pieces alone: it has no meshes and no sewing to write "
            f"as {', '.join(refused)}; export that from each of the builds"
        )
    if not build.pieces:
        raise ExportError(f"{folder}: no piece was made, so there is nothing to export")
    done = Exported()
    for name in formats:
        EXPORTERS[name](build, target, done)
    return done


def export(
    folder: Path, formats: Sequence[str], target: Path | None = None, certificate: bool = False
) -> Exported:
    """Write formats of the build in `folder` into `target`, by default its folder `exports`: all of them or none.

    What is written inside the build's folder is added to the files that its report lists; a certificate that is there
    speaks of the build as it was before, so that PDFs which end with it go to another folder.

    Raises
    ------
    ExportError
        As `write_exports`, or the target can't be written.
    """
    target = folder / EXPORTS if target is None else target
    inside = target.resolve().is_relative_to(folder.resolve())
    if certificate and not any(name.startswith("pdf") for name in formats):
        raise ExportError("a certificate is printed at the end of PDFs: add one of them to --format, such as pdf-a4")
    if certificate and inside:
        raise ExportError(
            f"{target}: lies in the build, and what is added there changes the files that the certificate speaks of; "
            "name a folder outside it with -o"
        )
    try:
        with tempfile.TemporaryDirectory(prefix="flatnet-export-") as staging:
            done = write_exports(folder, formats, Path(staging), certificate)
            target.mkdir(parents=True, exist_ok=True)
            for name in done.files:
                (target / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.move(Path(staging) / name, target / name)
        if inside:
            _list_in_report(folder, [(target / name).resolve() for name in done.files])
            if (folder / CERTIFICATE).is_file():
                done.notes.append(f"{CERTIFICATE} is older than these files: run `flatnet verify {folder}` again")
    except OSError as error:
        raise ExportError(f"{target}: can't be written: {error.strerror or error}; name another with -o") from None
    return done


def _list_in_report(folder: Path, files: Sequence[Path]) -> None:
    """So that the next build removes them with the build that they were made from."""
    report = json.loads((folder / REPORT).read_text(encoding="utf-8"))
    new = {file.relative_to(folder.resolve()).as_posix() for file in files}
    report["files"] = sorted({*report["files"], *new})
    unfinished = folder / f"{REPORT}.new"
    unfinished.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    os.replace(unfinished, folder / REPORT)
