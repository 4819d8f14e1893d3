"""The command `flatnet`: parses, calls, prints."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from flatnet.build import BuildResult, build, check
from flatnet.export.output import OutputError
from flatnet.project import ProjectError
from flatnet.report.build_files import BuildFilesError
from flatnet.report.pictures import PictureError, draw
from flatnet.report.summary import network_lines, summary_lines
from flatnet.version import VERSION

EXIT_INVALID, EXIT_INTERRUPTED = 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit status: 0 all made, 1 some failed, 2 invalid, 130 interrupted."""
    options = _parser().parse_args(arguments)
    try:
        if options.command == "check":
            project, network = check(options.project)
            print("\n".join(network_lines(project, network)))
            return 1 if network.failed else 0
        if options.command == "draw":
            print(draw(options.folder, options.picture))
            return 0
        result = _build(options.project, options.out)
        print("\n".join(summary_lines(result.report, result.folder)))
        return result.exit_status
    except ProjectError as error:
        print(error, file=sys.stderr)
        print(f"{len(error.problems)} problem(s); nothing was written.", file=sys.stderr)
        return EXIT_INVALID
    except (OutputError, BuildFilesError, PictureError) as error:
        print(error, file=sys.stderr)
        return EXIT_INVALID
    except KeyboardInterrupt:
        print("interrupted; nothing was written.", file=sys.stderr)
        return EXIT_INTERRUPTED


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
    text = "draw the network, patches and layouts of a build as one PNG (needs flatnet[pictures])"
    command = commands.add_parser("draw", help=text, description=text)
    command.add_argument("folder", type=Path, metavar="OUT", help="output folder of a build")
    command.add_argument("-o", "--out", type=Path, metavar="FILE.png", dest="picture", help="else OUT.png")
    return parser


def _build(project: Path, out: Path) -> BuildResult:
    """Build with a progress bar on a terminal, with plain lines elsewhere."""
    if not sys.stderr.isatty():
        return build(project, out, lambda text, done, total: print(f"[{done}/{total}] {text}", file=sys.stderr))
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading", total=None)
        return build(
            project,
            out,
            lambda text, done, total: bar.update(task, description=text, completed=done, total=total),
        )
