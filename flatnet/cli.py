"""The command `flatnet`: parses, calls, prints."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from flatnet.build import BuildResult, build, check
from flatnet.build import Progress as BuildProgress
from flatnet.diagnosis import NoSuchPatchError, diagnose_project
from flatnet.export.formats import EXPORTERS, export
from flatnet.export.output import OutputError
from flatnet.export.written_build import ExportError
from flatnet.lay import LayError, lay
from flatnet.nesting.instance import InstanceError
from flatnet.parameters import FINAL_SECONDS, NestingParameters
from flatnet.project import ProjectError
from flatnet.report.build_files import BuildFilesError
from flatnet.report.diagnosis_text import diagnosis_lines, ring_lines
from flatnet.report.pictures import PictureError, draw, draw_diagnoses
from flatnet.report.summary import counted, layout_lines, network_lines, summary_lines
from flatnet.start import DrawingOptions, faces, new
from flatnet.verify import NotABuildError, verify
from flatnet.verify.certificate import FILE as CERTIFICATE
from flatnet.verify.table import table
from flatnet.version import VERSION

EXIT_INVALID, EXIT_INTERRUPTED = 2, 130
#: What a command refuses to do; their texts are for people.
REFUSALS = (
    OutputError,
    ExportError,
    BuildFilesError,
    PictureError,
    NoSuchPatchError,
    NotABuildError,
    LayError,
    InstanceError,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit status: 0 all made, 1 some failed, 2 invalid, 130 interrupted."""
    options = _parser().parse_args(arguments)
    _end_as_by_ctrl_c()
    try:
        if options.command == "check":
            project, network = check(options.project)
            _say("\n".join(network_lines(project, network)), sys.stdout)
            return 1 if network.failed else 0
        if options.command == "draw":
            _say(str(draw(options.folder, options.picture)), sys.stdout)
            return 0
        if options.command == "export":
            exported = export(options.folder, options.format, options.out, options.certificate)
            _say("\n".join([*exported.files, *exported.notes]), sys.stdout)
            return 0
        if options.command == "verify":
            return _verify(options.folder)
        if options.command == "faces":
            drawing = DrawingOptions(options.units, options.up, options.snap, options.join_crossings)
            _say("\n".join(faces(options.network, options.out, drawing).lines), sys.stdout)
            return 0
        if options.command == "new":
            _say("\n".join(new(options.out, options.mesh, options.units, options.up).lines), sys.stdout)
            return 0
        if options.command == "diagnose":
            return _diagnose(options.project, options.patch, options.picture, options.workers)
        if options.command == "nest":
            result = _nest(options)
            _say("\n".join(layout_lines(result.report, result.folder)), sys.stdout)
            return result.exit_status
        result = _build(options)
        _say("\n".join(summary_lines(result.report, result.folder)), sys.stdout)
        return result.exit_status
    except ProjectError as error:
        written = "; nothing was written" if options.command in ("build", "nest") else ""
        _say(f"{error}\n{counted(len(error.problems), 'problem')}{written}.", sys.stderr)
        return EXIT_INVALID
    except REFUSALS as error:
        _say(str(error), sys.stderr)
        return EXIT_INVALID
    except KeyboardInterrupt:
        _say("interrupted; nothing was written.", sys.stderr)
        return EXIT_INTERRUPTED


def _end_as_by_ctrl_c() -> None:
    """What else ends a process (SIGTERM, a terminal that closes) cleans up as Ctrl-C does."""
    if threading.current_thread() is not threading.main_thread():
        return
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:  # nohup stays nohup
            signal.signal(number, signal.default_int_handler)


def _say(text: str, stream: TextIO | None) -> None:
    """Print for whoever listens: a pipe that closed (`| head`) stops no build and changes no exit status."""
    if stream is None:  # closed from the start
        return
    encoding = stream.encoding or "utf-8"
    try:
        print(text.encode(encoding, "backslashreplace").decode(encoding), file=stream, flush=True)
    except OSError:
        # What is still buffered would fail again when Python ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="flatnet", description="Flattenable patches for a network of space curves, laid out for cutting."
    )
    parser.add_argument("--version", action="version", version=f"flatnet {VERSION}")
    commands = parser.add_subparsers(dest="command", required=True)
    for name, text in (
        ("build", "fit all patches of a project and write pieces, layouts and a report"),
        ("check", "read and check a project and find its faces, without fitting"),
    ):
        command = commands.add_parser(name, help=text, description=text)
        command.add_argument("project", type=Path, metavar="PROJECT.yaml")
        if name == "build":
            command.add_argument("-o", "--out", type=Path, default=Path("out"), help="output folder (default: out)")
            command.add_argument(
                "--auto-split", action="store_true", help="divide patches that fail or wrinkle by the best cut found"
            )
            _add_workers(command)
            _add_nesting(command)
    text = "lay out the pieces of one or several builds together, or a published nesting problem"
    command = commands.add_parser("nest", help=text, description=text)
    text = "output folder of a build, or one strip packing problem (JSON)"
    command.add_argument("sources", type=Path, nargs="+", metavar="SOURCE", help=text)
    command.add_argument("-o", "--out", type=Path, default=Path("layout"), help="output folder (default: layout)")
    text = f"time of the engine for each sheet (default: {NestingParameters.seconds})"
    command.add_argument("--seconds", type=_seconds, default=NestingParameters.seconds, metavar="N", help=text)
    text = "lay on these: a file with `materials` as a project file has them, in place of those of the same name"
    command.add_argument("--materials", type=Path, metavar="FILE.yaml", help=text)
    command.add_argument("--seed", type=int, default=NestingParameters.seed, metavar="N", help="of the engine")
    _add_nesting(command)
    text = "try cuts on the patches that fail or wrinkle, and print the best ones ready to paste"
    command = commands.add_parser("diagnose", help=text, description=text)
    command.add_argument("project", type=Path, metavar="PROJECT.yaml")
    text = "only this one, also where nothing is wrong with it (may be repeated)"
    command.add_argument("--patch", action="append", default=[], metavar="NAME", help=text)
    _add_workers(command)
    command.add_argument(
        "-o", "--out", type=Path, metavar="FILE.png", dest="picture", help="draw them (needs matplotlib)"
    )
    text = "draw the network, patches and layouts of a build as one PNG (needs matplotlib)"
    command = commands.add_parser("draw", help=text, description=text)
    command.add_argument("folder", type=Path, metavar="OUT", help="output folder of a build")
    command.add_argument("-o", "--out", type=Path, metavar="FILE.png", dest="picture", help="else OUT.png")
    text = "write a build's pieces and layouts in other formats"
    command = commands.add_parser("export", help=text, description=text)
    command.add_argument("folder", type=Path, metavar="OUT", help="output folder of a build")
    text = f"one or more, with commas between: {', '.join(EXPORTERS)}"
    command.add_argument("--format", type=_formats, required=True, metavar="FORMAT", help=text)
    command.add_argument("-o", "--out", type=Path, metavar="DIR", help="folder to write to (default: OUT/exports)")
    command.add_argument("--certificate", action="store_true", help="PDFs end with what `flatnet verify` certified")
    text = "check a build from its written files alone and write certificate.json"
    command = commands.add_parser("verify", help=text, description=text)
    command.add_argument("folder", type=Path, metavar="OUT", help="output folder of a build")
    text = "list and draw the faces of a drawing or a project; of a drawing, write a project to start from"
    command = commands.add_parser("faces", help=text, description=text)
    text = "a drawing (CSV, DXF, JSON, OBJ, SVG), or a PROJECT.yaml"
    command.add_argument("network", type=Path, metavar="NETWORK", help=text)
    text = "project file to write (default: the drawing's name); of a project, the picture"
    command.add_argument("-o", "--out", type=Path, metavar="FILE", help=text)
    command.add_argument("--snap", default="", metavar="MM", help="ends this near become one node")
    command.add_argument("--join-crossings", action="store_true", help="curves that cross get a node there")
    _add_unit_and_axis(command)
    text = "write a project to start from: with a patch on a mesh, or a first example"
    command = commands.add_parser("new", help=text, description=text)
    text = "project file to write (default: project.yaml)"
    command.add_argument("out", type=Path, nargs="?", default=Path("project.yaml"), metavar="PROJECT.yaml", help=text)
    command.add_argument("--mesh", type=Path, metavar="FILE", help="an OBJ, STL or PLY to draw on")
    _add_unit_and_axis(command)
    return parser


def _add_workers(command: argparse.ArgumentParser) -> None:
    most = "patches fitted at once (default: one for each core)"
    command.add_argument("--workers", type=_positive, metavar="N", help=most)


def _add_nesting(command: argparse.ArgumentParser) -> None:
    command.add_argument("--final", action="store_true", help=f"nest for {FINAL_SECONDS} s, for the layout that is cut")
    command.add_argument("--nest-again", action="store_true", help="start over where a layout is stored in OUT")


def _seconds(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 3600:
        raise argparse.ArgumentTypeError(f"expected whole seconds from 1 to 3600, got {text!r}")
    return int(text)


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a number from 1, got {text!r}")
    return int(text)


def _formats(text: str) -> list[str]:
    names = list(dict.fromkeys(text.split(",")))
    for name in names:
        if name not in EXPORTERS:
            raise argparse.ArgumentTypeError(f"unknown format {name!r}; known: {', '.join(EXPORTERS)}")
    return names


def _add_unit_and_axis(command: argparse.ArgumentParser) -> None:
    """What a drawing or a mesh does not say of itself."""
    command.add_argument("--units", default="", help="of the file: mm (default), cm, dm, m, in, or mm per unit")
    command.add_argument("--up", default="", choices=("x", "y", "z"), help="the file's up axis (default: z)")


def _diagnose(project: Path, names: Sequence[str], picture: Path | None, workers: int | None) -> int:
    """Print what was found; 0 where nothing is wrong, or a cut was found for all that is, else 1."""
    found = diagnose_project(project, names, _say_progress, workers)
    for diagnosis in found.diagnoses:
        _say("\n".join(diagnosis_lines(found.project, diagnosis)), sys.stdout)
    for ring in found.rings:
        _say("\n".join(ring_lines(found.project, ring)), sys.stdout)
    for finding in found.not_fitted:
        _say(str(finding), sys.stdout)
    if not (found.diagnoses or found.rings or found.not_fitted):
        _say(f"{counted(found.fitted, 'patch', 'patches')} made, none of them wrinkled.", sys.stdout)
    if picture is not None and found.diagnoses:
        _say(str(draw_diagnoses(found.project.name, found.diagnoses, picture)), sys.stdout)
    return 0 if found.all_cured else 1


def _verify(folder: Path) -> int:
    """Print what was measured; 0 where all of it is as it should be, else 1."""
    certificate = verify(folder)
    _say(table(certificate), sys.stdout)
    result = "verified" if certificate.passed else f"{counted(len(certificate.problems), 'check')} failed"
    _say(f"{result}: {counted(len(certificate.hashes), 'file')}; {folder / CERTIFICATE}", sys.stdout)
    return 0 if certificate.passed else 1


def _say_progress(text: str, done: int, total: int) -> None:
    _say(f"[{done}/{total}] {text}", sys.stderr)


def _build(options: argparse.Namespace) -> BuildResult:
    return _shown(
        lambda progress: build(
            options.project,
            options.out,
            progress,
            options.workers,
            split=options.auto_split,
            nest_again=options.nest_again,
            final=options.final,
        )
    )


def _nest(options: argparse.Namespace) -> BuildResult:
    parameters = NestingParameters(options.seconds, options.seed)
    if options.final:
        parameters = parameters.final()
    return _shown(
        lambda progress: lay(
            options.sources, options.out, parameters, progress, options.nest_again, options.materials
        )
    )


def _shown(work: Callable[[BuildProgress], BuildResult]) -> BuildResult:
    """Work with a progress bar on a terminal, with plain lines elsewhere."""
    if sys.stderr is None or not sys.stderr.isatty():
        return work(_say_progress)
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading", total=None)
        return work(lambda text, done, total: bar.update(task, description=text, completed=done, total=total))
