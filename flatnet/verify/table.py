"""The table of `flatnet verify`: one line a check, then all that failed."""

from __future__ import annotations

import shutil
from io import StringIO

from rich.console import Console
from rich.table import Table
from rich.text import Text

from flatnet.verify.certificate import Certificate, worst

#: Columns of a table that goes into a file or a pipe.
WIDE = 160
#: Failures that are printed; certificate.json has all.
MOST_SHOWN = 30


def table(certificate: Certificate) -> str:
    """Text for the terminal."""
    grid = Table(box=None, pad_edge=False, header_style="")
    for title, side in (("check", "left"), ("things", "right"), ("worst", "right"), ("allowed", "right"), ("", "left")):
        grid.add_column(title, justify=side, no_wrap=True)  # type: ignore[arg-type]
    grid.add_column("at", overflow="fold")
    for check, measured in certificate.checks.items():
        failed = sum(not one.passed for one in measured)
        most = worst(measured)
        row = (
            check,
            str(len(measured)),
            f"{most.amount:.2g} {most.unit}".strip(),
            f"{most.allowed:.2g}",
            f"{failed} FAILED" if failed else "ok",
            (most.subject or most.file) if most.amount else "",
        )
        grid.add_row(*map(Text, row))
    text = StringIO()
    Console(file=text, width=shutil.get_terminal_size((WIDE, 0)).columns, color_system=None).print(grid)
    lines = [line.rstrip() for line in text.getvalue().splitlines()]
    problems = certificate.problems
    lines += [str(one) for one in problems[:MOST_SHOWN]]
    if len(problems) > MOST_SHOWN:
        lines.append(f"... and {len(problems) - MOST_SHOWN} more")
    return "\n".join(lines)
