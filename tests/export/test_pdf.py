"""Sheets longer than most: how exact a PDF's coordinates are far from the page's corner, and what no page may hold."""

import numpy as np
import pypdf
from pieces import LETTER_F, cloth, piece
from test_golden import pdf_lines

from flatnet.export.pdf import LONGEST, Pages, draw_full_size
from flatnet.nesting import Layout, Placement
from flatnet.parameters import STROKES

#: Of no short decimals, so that every digit that is lost shows.
F = piece(LETTER_F / 7.0 * 10.0, cloth(), name="f", cut=2)


def drawn(path, length):
    placements = (Placement(F, 1, False, 0.0, 1.0, 1.0), Placement(F, 2, False, 33.0, length, 99.0))
    layout = Layout(cloth(width=300.0), placements)
    pages = Pages(path, "long", STROKES)
    draw_full_size(pages, layout, "long", ["1 hem"])
    pages.save()
    return layout, pypdf.PdfReader(path).pages


def test_coordinates_keep_their_accuracy_far_from_the_corner(tmp_path):
    layout, (page,) = drawn(tmp_path / "long.pdf", 4876.543210)
    lines = pdf_lines(page)[0, 0, 1]
    assert len(lines) == 2
    shift = lines[0] - layout.placements[0].place(F.sew_line)
    wanted = layout.placements[1].place(F.sew_line) + shift.mean(axis=0)
    assert np.abs(lines[1] - wanted).max() <= 0.0005


def test_a_sheet_that_no_page_can_hold_is_divided(tmp_path):
    layout, (cover, *pages) = drawn(tmp_path / "longer.pdf", 7876.543210)
    assert len(pages) == 2
    assert all(float(page.mediabox[2]) <= 14_400 for page in (cover, *pages))
    step = 0.98 * LONGEST - 20.0 - 10.0
    (first,), (second,) = (pdf_lines(page)[0, 0, 1] for page in pages)
    for line, placement, column in ((first, layout.placements[0], 0), (second, layout.placements[1], 1)):
        along = line[:, 0] - placement.place(F.sew_line)[:, 0]
        assert np.abs(along - (10.0 - column * step)).max() <= 0.0005
