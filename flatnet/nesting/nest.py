"""Nest the pieces of one material: layouts that passed the checker, and what could not be laid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from flatnet.failure import Finding
from flatnet.nesting.check import TOLERANCE, check_layouts
from flatnet.nesting.engine import EngineError
from flatnet.nesting.layout import Copy, Layout, Placement, copies_of
from flatnet.nesting.orientation import too_large
from flatnet.nesting.roll import nest_on_roll
from flatnet.nesting.rows import lay_in_rows
from flatnet.nesting.stored import Stored, digest_of, restore
from flatnet.parameters import NestingParameters
from flatnet.pattern.piece import Piece
from flatnet.project.model import Material

Engine = Callable[[Sequence[Copy]], list[Placement]]
Progress = Callable[[str], None]


def nest(
    pieces: Sequence[Piece],
    material: Material,
    parameters: NestingParameters,
    stored: Stored | None = None,
    progress: Progress = lambda text: None,
) -> tuple[tuple[Layout, ...], tuple[Finding, ...]]:
    """Lay every copy of the pieces on sheets of a material.

    A layout stored for the same input is used again. Where the engine gives no valid layout, the pieces are
    laid in plain rows and the layout is a draft.

    Returns
    -------
    layouts : one per sheet, each valid; none where no piece fits.
    findings : `sheet_too_small` for every piece left out (its `patch` says which); `draft_layout`, which
        names no patch, where the layouts are drafts.
    """
    findings = [finding for piece in pieces if (finding := too_large(piece, material))]
    too_large_names = {finding.patch for finding in findings}
    laid = [piece for piece in pieces if piece.name not in too_large_names]
    copies = copies_of(laid)
    if not copies:
        return (), tuple(findings)

    digest = digest_of(laid, material, parameters)
    layouts = restore(stored or {}, digest, laid, material, parameters.seconds)
    if layouts is not None and not check_layouts(layouts, laid):
        progress(f"{material.name}: the layout is unchanged")
        return layouts, tuple(findings)

    try:
        layouts = _nested(copies, material, parameters, progress)
        problems = check_layouts(layouts, laid)
        if problems:
            raise EngineError(f"its layout is not valid: {'; '.join(problems[:3])}")
        draft = False
    except EngineError as error:
        findings.append(_draft(material, error))
        progress(str(findings[-1]))
        draft = True
        layouts = _on_sheets(copies, material, lambda rest: lay_in_rows(rest, material))
        problems = check_layouts(layouts, laid)
        if problems:
            raise RuntimeError(f"{material.name}: plain rows are not valid: {'; '.join(problems)}") from error
    layouts = tuple(
        replace(layout, draft=draft, digest=digest, seconds=parameters.seconds) for layout in layouts
    )
    for layout in layouts:
        progress(f"{material.name}: {layout.used_length:.1f} mm used, {100 * layout.utilisation:.1f} %")
    return layouts, tuple(findings)


def _nested(
    copies: Sequence[Copy], material: Material, parameters: NestingParameters, progress: Progress
) -> tuple[Layout, ...]:
    """What the engine finds in its time, or plain rows where it found nothing shorter (a loaded machine)."""
    in_rows = _on_sheets(copies, material, lambda rest: lay_in_rows(rest, material))
    if len(copies) == 1:  # nothing to optimise but its rotation
        return in_rows

    def lay(rest: Sequence[Copy]) -> list[Placement]:
        told = f"{material.name}: nesting {len(rest)} copies for {parameters.seconds} s"
        progress(told)
        return nest_on_roll(rest, material, parameters, lambda part: progress(f"{told}, {100.0 * part:.1f} %"))

    nested = _on_sheets(copies, material, lay)
    return min(nested, in_rows, key=lambda sheets: (len(sheets), sheets[-1].used_length))


def _on_sheets(copies: Sequence[Copy], material: Material, engine: Engine) -> tuple[Layout, ...]:
    """Sheets of at most the material's length: what lies beyond it on one is nested again on the next.

    Every piece fits the length in every rotation that an engine is offered, so the first piece of a sheet
    always stays on it.
    """
    names = list(dict.fromkeys(copy.piece.name for copy in copies))
    sheets: list[Layout] = []
    rest = list(copies)
    while rest:
        placements = sorted(engine(rest), key=lambda placement: (names.index(placement.piece.name), placement.copy))
        if material.length is not None:
            limit = material.length + 0.5 * TOLERANCE
            placements = [p for p in placements if p.place(p.piece.cut_line)[:, 0].max() <= limit]
        placed = {(p.piece.name, p.copy) for p in placements}
        left = [copy for copy in rest if (copy.piece.name, copy.number) not in placed]
        if len(left) == len(rest):
            raise EngineError(f"no copy lies within the length of {material.length:g} mm")
        sheets.append(Layout(material, tuple(placements), len(sheets) + 1))
        rest = left
    return tuple(sheets)


def _draft(material: Material, error: EngineError) -> Finding:
    return Finding(
        code="draft_layout",
        stage="nesting",
        message=f"the nesting engine gave no layout for material '{material.name}': {error}. "
        "The pieces are laid in plain rows.",
        remedy="The layout is valid and wastes material; build again, with more seconds for nesting.",
    )
