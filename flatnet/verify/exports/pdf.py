"""Read the lines of a PDF's pages, in mm from the lower left corner of each; by pypdf."""

from __future__ import annotations

import logging
from io import BytesIO
from typing import Any

import numpy as np

from flatnet.verify.drawing import DrawnLine
from flatnet.verify.exports.lines import drawn_line
from flatnet.verify.written import DamagedError

MM = 25.4 / 72.0  # in a point
#: Operators that end a path: this one strokes it, those fill it or do nothing.
STROKED, UNSEEN = b"S", (b"f", b"n")


def read_pdf(file: str, content: bytes) -> list[list[DrawnLine]]:
    """Page by page what is stroked of straight parts.

    Raises
    ------
    DamagedError
        It is no PDF, or cut short.
    ImportError
        pypdf is not installed.
    """
    import pypdf
    from pypdf.errors import PyPdfError

    logging.getLogger("pypdf").setLevel(logging.CRITICAL)  # what is wrong is said here
    try:
        reader = pypdf.PdfReader(BytesIO(content), strict=True)
        return [_lines(page, reader) for page in reader.pages]
    except (PyPdfError, ArithmeticError, LookupError, TypeError, ValueError) as error:
        raise DamagedError(file, f"is no PDF, or cut short: {error}") from None


def _lines(page: Any, reader: Any) -> list[DrawnLine]:
    from pypdf.generic import ContentStream

    matrix, kept = np.eye(3), []
    point: list[list[float]] = []
    lines: list[DrawnLine] = []
    closed = False
    contents = page.get_contents()
    for operands, operator in ContentStream(contents, reader).operations if contents is not None else ():
        if operator == b"q":
            kept.append(matrix)
        elif operator == b"Q":
            matrix = kept.pop()
        elif operator == b"cm":
            a, b, c, d, x, y = map(float, operands)
            matrix = np.array([[a, b, 0.0], [c, d, 0.0], [x, y, 1.0]]) @ matrix
        elif operator == b"m":
            point, closed = [[*map(float, operands), 1.0]], False
        elif operator == b"l":
            point.append([*map(float, operands), 1.0])
        elif operator == b"h":
            closed = True
        elif operator == STROKED and point:
            lines.append(drawn_line(MM * (np.array(point) @ matrix)[:, :2], closed))
            point = []
        elif operator in UNSEEN:
            point = []
    return lines
