"""The words of the command line: commands, options, and what they may be."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeAlias

from flatnet.parameters import EXPORT_FORMATS, FINAL_SECONDS, NestingParameters
from flatnet.version import VERSION

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """The options by name, and `command`; ends the process with a message where they are none."""
    parser = argparse.ArgumentParser(
        prog="flatnet", description="Flattenable patches for a network of space curves, laid out for cutting."
    )
    parser.add_argument("--version", action="version", version=f"flatnet {VERSION}")
    commands = parser.add_subparsers(dest="command", required=True)
    for add in (_build, _check, _nest, _diagnose, _draw, _export, _verify, _faces, _new):
        add(commands)
    return parser.parse_args(arguments)


def _add(commands: Commands, name: str, text: str) -> argparse.ArgumentParser:
    return commands.add_parser(name, help=text, description=text)


def _build(commands: Commands) -> None:
    command = _add(commands, "build", "fit all patches of a project and write pieces, layouts and a report")
    _add_project(command)
    command.add_argument("-o", "--out", type=Path, default=Path("out"), help="output folder (default: out)")
    text = "divide patches that fail or wrinkle by the best cut found"
    command.add_argument("--auto-split", action="store_true", help=text)
    _add_workers(command)
    _add_nesting(command)


def _check(commands: Commands) -> None:
    _add_project(_add(commands, "check", "read and check a project and find its faces, without fitting"))


def _nest(commands: Commands) -> None:
    text = "lay out the pieces of one or several builds together, or a published nesting problem"
    command = _add(commands, "nest", text)
    text = "output folder of a build, or one strip packing problem (JSON)"
    command.add_argument("sources", type=Path, nargs="+", metavar="SOURCE", help=text)
    command.add_argument("-o", "--out", type=Path, default=Path("layout"), help="output folder (default: layout)")
    text = f"time of the engine for each sheet (default: {NestingParameters.seconds})"
    command.add_argument("--seconds", type=_whole(1, 3600), default=NestingParameters.seconds, metavar="N", help=text)
    text = "lay on these: a file with `materials` as a project file has them, in place of those of the same name"
    command.add_argument("--materials", type=Path, metavar="FILE.yaml", help=text)
    seed = _whole(0, 2**31 - 1)
    command.add_argument("--seed", type=seed, default=NestingParameters.seed, metavar="N", help="of the engine")
    _add_nesting(command)


def _diagnose(commands: Commands) -> None:
    text = "try cuts on the patches that fail or wrinkle, and print the best ones ready to paste"
    command = _add(commands, "diagnose", text)
    _add_project(command)
    text = "only this one, also where nothing is wrong with it (may be repeated)"
    command.add_argument("--patch", action="append", default=[], metavar="NAME", help=text)
    _add_workers(command)
    text = "draw them (needs matplotlib)"
    command.add_argument("-o", "--out", type=Path, metavar="FILE.png", dest="picture", help=text)


def _draw(commands: Commands) -> None:
    text = "draw the network, patches and layouts of a build as one PNG (needs matplotlib)"
    command = _add(commands, "draw", text)
    _add_folder(command)
    command.add_argument("-o", "--out", type=Path, metavar="FILE.png", dest="picture", help="else OUT.png")


def _export(commands: Commands) -> None:
    command = _add(commands, "export", "write a build's pieces and layouts in other formats")
    _add_folder(command)
    text = f"one or more, with commas between: {', '.join(EXPORT_FORMATS)}"
    command.add_argument("--format", type=_formats, required=True, metavar="FORMAT", help=text)
    command.add_argument("-o", "--out", type=Path, metavar="DIR", help="folder to write to (default: OUT/exports)")
    text = "PDFs end with what `flatnet verify` certified; needs -o with a folder outside OUT"
    command.add_argument("--certificate", action="store_true", help=text)


def _verify(commands: Commands) -> None:
    _add_folder(_add(commands, "verify", "check a build from its written files alone and write certificate.json"))


def _faces(commands: Commands) -> None:
    text = "list and draw the faces of a drawing or a project; of a drawing, write a project to start from"
    command = _add(commands, "faces", text)
    text = "a drawing (CSV, DXF, JSON, OBJ, SVG), or a PROJECT.yaml"
    command.add_argument("network", type=Path, metavar="NETWORK", help=text)
    text = "project file to write (default: the drawing's name); of a project, the picture"
    command.add_argument("-o", "--out", type=Path, metavar="FILE", help=text)
    command.add_argument("--snap", default="", metavar="MM", help="ends this near become one node")
    command.add_argument("--join-crossings", action="store_true", help="curves that cross get a node there")
    _add_unit_and_axis(command)


def _new(commands: Commands) -> None:
    command = _add(commands, "new", "write a project to start from: with a patch on a mesh, or a first example")
    text = "project file to write (default: project.yaml)"
    command.add_argument("out", type=Path, nargs="?", default=Path("project.yaml"), metavar="PROJECT.yaml", help=text)
    command.add_argument("--mesh", type=Path, metavar="FILE", help="an OBJ, STL or PLY to draw on")
    _add_unit_and_axis(command)


def _add_project(command: argparse.ArgumentParser) -> None:
    command.add_argument("project", type=Path, metavar="PROJECT.yaml")


def _add_folder(command: argparse.ArgumentParser) -> None:
    command.add_argument("folder", type=Path, metavar="OUT", help="output folder of a build")


def _add_workers(command: argparse.ArgumentParser) -> None:
    most = "patches fitted at once (default: one for each core)"
    command.add_argument("--workers", type=_whole(1), metavar="N", help=most)


def _add_nesting(command: argparse.ArgumentParser) -> None:
    command.add_argument("--final", action="store_true", help=f"nest for {FINAL_SECONDS} s, for the layout that is cut")
    command.add_argument("--nest-again", action="store_true", help="start over where a layout is stored in OUT")


def _add_unit_and_axis(command: argparse.ArgumentParser) -> None:
    """What a drawing or a mesh does not say of itself."""
    command.add_argument("--units", default="", help="of the file: mm (default), cm, dm, m, in, or mm per unit")
    command.add_argument("--up", default="", choices=("x", "y", "z"), help="the file's up axis (default: z)")


def _whole(least: int, most: int | None = None) -> Callable[[str], int]:
    def parser(text: str) -> int:
        if not text.isdecimal() or int(text) < least or (most is not None and int(text) > most):
            upwards = "" if most is None else f" to {most}"
            raise argparse.ArgumentTypeError(f"expected a whole number from {least}{upwards}, got {text!r}")
        return int(text)

    return parser


def _formats(text: str) -> list[str]:
    names = list(dict.fromkeys(text.split(",")))
    for name in names:
        if name not in EXPORT_FORMATS:
            raise argparse.ArgumentTypeError(f"unknown format {name!r}; known: {', '.join(EXPORT_FORMATS)}")
    return names
