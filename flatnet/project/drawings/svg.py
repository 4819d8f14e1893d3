"""SVG: its paths and shapes in the plane z = 0, in mm at true scale, y up from the page's upper left corner."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from xml.etree.ElementTree import ParseError

import numpy as np

from flatnet.project.drawings.file_curve import (
    DrawingError,
    FileCurve,
    Floats,
    cubic_points,
    path_curves,
    quadratic_points,
)


def read_svg(file: Path) -> list[FileCurve]:
    """Every path, line, polyline, polygon, rectangle, circle and ellipse, named by its id; text is passed over.

    Needs svgelements.
    """
    try:
        import svgelements
    except ModuleNotFoundError as error:
        raise DrawingError(f"reading SVG needs {error.name}: pip install svgelements") from None
    try:
        shapes = [e for e in svgelements.SVG.parse(str(file)).elements() if isinstance(e, svgelements.Shape)]
        paths = [(shape.id or "", svgelements.Path(shape)) for shape in shapes]
    except (ParseError, ValueError, TypeError, AttributeError) as error:
        raise DrawingError(f"no SVG that can be read: {error}") from None
    mm = 1.0 / svgelements.Length("1mm").value(ppi=96.0)  # its pixel: 25.4 / 96 but for the seventh digit

    def in_mm(*points: complex) -> Floats:
        """svgelements' points, in pixels and y down, (n, 3) mm and y up."""
        return np.array([[mm * point.real, -mm * point.imag, 0.0] for point in points])

    curves = []
    for name, path in paths:
        for part in path.as_subpaths():
            pieces: list[Floats] = []
            for segment in svgelements.Path(part):
                if isinstance(segment, svgelements.Move):
                    continue
                if isinstance(segment, (svgelements.Line, svgelements.Close)):
                    pieces.append(in_mm(segment.start, segment.end))
                elif isinstance(segment, svgelements.Arc):
                    cubics = segment.as_cubic_curves()
                    pieces += [cubic_points(in_mm(c.start, c.control1, c.control2, c.end)) for c in cubics]
                elif isinstance(segment, svgelements.CubicBezier):
                    control = in_mm(segment.start, segment.control1, segment.control2, segment.end)
                    pieces.append(cubic_points(control))
                else:
                    pieces.append(quadratic_points(in_mm(segment.start, segment.control, segment.end)))
            curves += path_curves(name, _chained(pieces))
    return curves


def _chained(pieces: list[Floats]) -> list[Floats]:
    """Each piece begins, to the last bit, where the one before it ends; arcs are off by round-off."""
    for piece, following in pairwise(pieces):
        following[0] = piece[-1]
    if pieces and np.linalg.norm(pieces[-1][-1] - pieces[0][0]) < 1e-9 * max(1.0, float(np.abs(pieces[0][0]).max())):
        pieces[-1][-1] = pieces[0][0]
    return pieces
