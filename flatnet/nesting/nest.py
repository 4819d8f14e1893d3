"""Nest the pieces of one material: layouts that passed the checker, and what could not be laid."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from flatnet.failure import Finding
from flatnet.nesting.check import check_layouts
from flatnet.nesting.engine import EngineError
from flatnet.nesting.hide import lay_on_hide, nest_on_hide
from flatnet.nesting.layout import Copy, Layout, Placement, copies_of, left_over
from flatnet.nesting.orientation import too_large
from flatnet.nesting.rectangle import nest_on_rectangle, within_length
from flatnet.nesting.rows import lay_in_rows
from flatnet.nesting.stored import Stored, digest_of, restore
from flatnet.parameters import NestingParameters
from flatnet.pattern.piece import Piece
from flatnet.project.model import Material

#: The copies that are left and the number of a sheet in, what lies on it out.
LaySheet = Callable[[Sequence[Copy], int], list[Placement]]
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
    laid in plain rows, on a hide one by one, and the layout is a draft.

    Returns
    -------
    layouts : one per sheet, each valid; none where no piece fits.
    findings : `sheet_too_small` for every piece that fits nowhere, `out_of_material` for those of which copies
        are left over (their `patch` says which); `draft_layout`, which names no patch, where the layouts are drafts.
    """
    findings = [finding for piece in pieces if (finding := too_large(piece, material))]
    too_large_names = {finding.patch for finding in findings}
    laid = [piece for piece in pieces if piece.name not in too_large_names]
    copies = copies_of(laid)
    if not copies:
        return (), tuple(findings)

    digest = digest_of(laid, material, parameters)
    layouts = restore(stored or {}, digest, laid, material, parameters.seconds)
    if layouts is not None:
        left = _left(copies, layouts) if np.isfinite(material.count) else []
        if not check_layouts(layouts, laid, left):
            progress(f"{material.name}: the layout is unchanged")
            return layouts, (*findings, *_out_of_material(left, material))

    try:
        layouts = _nested(copies, material, parameters, progress)
        problems = check_layouts(layouts, laid, _left(copies, layouts))
        if problems:
            raise EngineError(f"its layout is not valid: {'; '.join(problems[:3])}")
        draft = False
    except EngineError as error:
        findings.append(_draft(material, error))
        progress(str(findings[-1]))
        draft = True
        layouts = _on_sheets(copies, material, _plainly(material))
        problems = check_layouts(layouts, laid, _left(copies, layouts))
        if problems:
            raise RuntimeError(f"{material.name}: the plain layout is not valid: {'; '.join(problems)}") from error
    layouts = tuple(
        replace(layout, draft=draft, digest=digest, seconds=parameters.seconds) for layout in layouts
    )
    for layout in layouts:
        progress(f"{material.name}: {layout.used_length:.1f} mm used, {100 * layout.utilisation:.1f} %")
    return layouts, (*findings, *_out_of_material(_left(copies, layouts), material))


def _nested(
    copies: Sequence[Copy], material: Material, parameters: NestingParameters, progress: Progress
) -> tuple[Layout, ...]:
    """What the engine finds in its time, or plain rows where it found nothing shorter (a loaded machine)."""

    def teller(rest: Sequence[Copy], sheet: int) -> Callable[[float], None]:
        of = f" on {'hide' if material.hides else 'sheet'} {sheet}" if sheet > 1 or material.hides else ""
        text = f"{material.name}: nesting {len(rest)} copies{of} for {parameters.seconds} s"
        progress(text)
        return lambda part: progress(f"{text}, {100.0 * part:.1f} %")

    def on_hide(rest: Sequence[Copy], sheet: int) -> list[Placement]:
        hide = material.hides[sheet - 1]
        return nest_on_hide(rest, hide, material, parameters, teller(rest, sheet))

    def on_rectangle(rest: Sequence[Copy], sheet: int) -> list[Placement]:
        return nest_on_rectangle(rest, material, parameters, teller(rest, sheet))

    if material.hides:
        return _on_sheets(copies, material, on_hide)
    in_rows = _on_sheets(copies, material, _plainly(material))
    if len(copies) == 1:  # nothing to optimise but its rotation
        return in_rows
    nested = _on_sheets(copies, material, on_rectangle)
    return min(nested, in_rows, key=lambda sheets: (len(_left(copies, sheets)), len(sheets), sheets[-1].used_length))


def _plainly(material: Material) -> LaySheet:
    """Without the engine."""
    if material.hides:
        return lambda rest, sheet: lay_on_hide(rest, material.hides[sheet - 1], material)
    return lambda rest, _: within_length(lay_in_rows(rest, material), material)


def _on_sheets(copies: Sequence[Copy], material: Material, lay_sheet: LaySheet) -> tuple[Layout, ...]:
    """Sheet after sheet, as many as there are; what does not lie on one is for the next.

    Every piece fits the length in every rotation that is offered, so the first piece of a sheet always stays on it,
    but for hides.
    """
    names = list(dict.fromkeys(copy.piece.name for copy in copies))
    sheets: list[Layout] = []
    rest, number = list(copies), 0
    while rest and number < material.count:
        number += 1
        placements = sorted(lay_sheet(rest, number), key=lambda p: (names.index(p.piece.name), p.copy))
        if placements:
            sheets.append(Layout(material, tuple(placements), number))
        elif not material.hides:
            raise EngineError(f"no copy lies within the length of {material.length:g} mm")
        rest = _left(copies, sheets)
    return tuple(sheets)


def _left(copies: Sequence[Copy], layouts: Sequence[Layout]) -> list[Copy]:
    """Those that lie on no sheet."""
    return left_over(copies, [placement for layout in layouts for placement in layout.placements])


def _out_of_material(left: Sequence[Copy], material: Material) -> list[Finding]:
    findings = []
    count = f"{material.count:g} {'hide' if material.hides else 'sheet'}{'s' * (material.count != 1)}"
    for name, missing in Counter(copy.piece.name for copy in left).items():
        piece = next(copy.piece for copy in left if copy.piece.name == name)
        zone = f" in zone '{piece.zone}'" if piece.zone else ""
        findings.append(
            Finding(
                code="out_of_material",
                stage="nesting",
                patch=name,
                amount=float(missing),
                unit="copies",
                message=f"{missing} of {piece.cut + piece.mirrored} copies have no room{zone} on material "
                f"'{material.name}', which has {count}.",
                remedy="Add material, or cut fewer copies; more seconds for nesting may find room.",
            )
        )
    return findings


def _draft(material: Material, error: EngineError) -> Finding:
    return Finding(
        code="draft_layout",
        stage="nesting",
        message=f"the nesting engine gave no layout for material '{material.name}': {error}. "
        f"The pieces are laid {'one by one' if material.hides else 'in plain rows'}.",
        remedy="The layout is valid and wastes material; build again, with more seconds for nesting.",
    )
