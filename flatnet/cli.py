"""The command `flatnet`: calls what its words ask for, and prints."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Sequence
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from flatnet.arguments import parse
from flatnet.build import BuildResult, build, check
from flatnet.build import Progress as BuildProgress
from flatnet.diagnosis import NoSuchPatchError, diagnose_project
from flatnet.export.formats import export
from flatnet.export.output import OutputError
from flatnet.export.written_build import ExportError
from flatnet.lay import LayError, lay
from flatnet.nesting.instance import InstanceError
from flatnet.parameters import NestingParameters
from flatnet.project import ProjectError
from flatnet.report.build_files import BuildFilesError
from flatnet.report.diagnosis_text import diagnosis_lines, ring_lines
from flatnet.report.pictures import PictureError, draw, draw_diagnoses
from flatnet.report.summary import counted, layout_lines, network_lines, summary_lines
from flatnet.start import DrawingOptions, faces, new
from flatnet.verify import NotABuildError, verify
from flatnet.verify.certificate import FILE as CERTIFICATE
from flatnet.verify.table import table

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


def _build(options: argparse.Namespace) -> int:
    def work(progress: BuildProgress) -> BuildResult:
        return build(
            options.project,
            options.out,
            progress,
            options.workers,
            split=options.auto_split,
            nest_again=options.nest_again,
            final=options.final,
        )

    result = _shown(work)
    _say_lines(summary_lines(result.report, result.folder))
    return result.exit_status


def _check(options: argparse.Namespace) -> int:
    project, network = check(options.project)
    _say_lines(network_lines(project, network))
    return 1 if network.failed else 0


def _nest(options: argparse.Namespace) -> int:
    parameters = NestingParameters(options.seconds, options.seed)
    if options.final:
        parameters = parameters.final()

    def work(progress: BuildProgress) -> BuildResult:
        return lay(options.sources, options.out, parameters, progress, options.nest_again, options.materials)

    result = _shown(work)
    _say_lines(layout_lines(result.report, result.folder))
    return result.exit_status


def _diagnose(options: argparse.Namespace) -> int:
    """0 where nothing is wrong, or a cut was found that cures all that is, else 1."""
    found = diagnose_project(options.project, options.patch, _say_progress, options.workers)
    for diagnosis in found.diagnoses:
        _say_lines(diagnosis_lines(found.project, diagnosis))
    for ring in found.rings:
        _say_lines(ring_lines(found.project, ring))
    _say_lines(map(str, found.not_fitted))
    if not (found.diagnoses or found.rings or found.not_fitted):
        _say_lines([f"{counted(found.fitted, 'patch', 'patches')} made, none of them wrinkled."])
    if options.picture is not None and found.diagnoses:
        _say_lines([str(draw_diagnoses(found.project.name, found.diagnoses, options.picture))])
    return 0 if found.all_cured else 1


def _draw(options: argparse.Namespace) -> int:
    _say_lines([str(draw(options.folder, options.picture))])
    return 0


def _export(options: argparse.Namespace) -> int:
    exported = export(options.folder, options.format, options.out, options.certificate)
    _say_lines([*exported.files, *exported.notes])
    return 0


def _verify(options: argparse.Namespace) -> int:
    """0 where all that was measured is as it should be, else 1."""
    certificate = verify(options.folder)
    result = "verified" if certificate.passed else f"{counted(len(certificate.problems), 'check')} failed"
    files = counted(len(certificate.hashes), "file")
    _say_lines([table(certificate), f"{result}: {files}; {options.folder / CERTIFICATE}"])
    return 0 if certificate.passed else 1


def _faces(options: argparse.Namespace) -> int:
    drawing = DrawingOptions(options.units, options.up, options.snap, options.join_crossings)
    _say_lines(faces(options.network, options.out, drawing).lines)
    return 0


def _new(options: argparse.Namespace) -> int:
    _say_lines(new(options.out, options.mesh, options.units, options.up).lines)
    return 0


#: What each command does; it returns the exit status.
COMMANDS: dict[str, Callable[[argparse.Namespace], int]] = {
    "build": _build,
    "check": _check,
    "nest": _nest,
    "diagnose": _diagnose,
    "draw": _draw,
    "export": _export,
    "verify": _verify,
    "faces": _faces,
    "new": _new,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit status: 0 all made, 1 some failed, 2 invalid, 130 interrupted."""
    options = parse(arguments)
    _end_as_by_ctrl_c()
    try:
        return COMMANDS[options.command](options)
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


def _say_lines(lines: Iterable[str]) -> None:
    if text := "\n".join(lines):
        _say(text, sys.stdout)


def _say_progress(text: str, done: int, total: int) -> None:
    _say(f"[{done}/{total}] {text}", sys.stderr)


def _shown(work: Callable[[BuildProgress], BuildResult]) -> BuildResult:
    """Work with a progress bar on a terminal, with plain lines elsewhere."""
    if sys.stderr is None or not sys.stderr.isatty():
        return work(_say_progress)
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading", total=None)
        return work(lambda text, done, total: bar.update(task, description=text, completed=done, total=total))
