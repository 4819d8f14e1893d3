"""Read the closed lines of a PDF's pages, in mm from the lower left corner of each; by pypdf."""

from __future__ import annotations

import logging
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatnet.verify.written import DamagedError

Floats = NDArray[np.float64]

MM = 25.4 / 72.0  # in a point


def read_pdf(file: str, content: bytes) -> list[list[Floats]]:
    """Page by page its closed paths, (k, 2) each.

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
        return [_closed_paths(page, reader) for page in reader.pages]
    except (PyPdfError, ArithmeticError, LookupError, TypeError, ValueError) as error:
        raise DamagedError(file, f"is no PDF, or cut short: {error}") from None


def _closed_paths(page: Any, reader: Any) -> list[Floats]:
    from pypdf.generic import ContentStream

    matrix, kept = np.eye(3), []
    point: list[list[float]] = []
    paths: list[Floats] = []
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
            point = [[*map(float, operands), 1.0]]
        elif operator == b"l":
            point.append([*map(float, operands), 1.0])
        elif operator == b"h" and point:
            paths.append(MM * (np.array(point) @ matrix)[:, :2])
            point = []
    return paths
