"""A curve as a drawing file has it: named points, in the file's own unit and axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Points that stand for one cubic Bezier segment or a comparable stretch of a smooth curve, after its first.
SAMPLES = 16
#: No curve is refined further than to this part of its largest coordinate.
FINEST = 1e-5
#: A path of several segments is smooth where it turns by no more than this from one to the next, rad.
SMOOTH = np.radians(5.0)


class DrawingError(ValueError):
    """A drawing that can't be read, or has no curve."""


@dataclass(frozen=True, eq=False)
class FileCurve:
    """One curve of a drawing.

    Attributes
    ----------
    name : as the file has it; "" where it has none.
    points : (n, 3) float; of a closed curve the last is the first.
    smooth : the points are samples of a smooth curve, not corners of a polyline.
    """

    name: str
    points: Floats
    smooth: bool = False

    def __post_init__(self) -> None:
        self.points.setflags(write=False)

    @property
    def closed(self) -> bool:
        return len(self.points) > 2 and bool((self.points[0] == self.points[-1]).all())


def cubic_points(control: Floats) -> Floats:
    """Points of a cubic Bezier segment from its (4, 3) control points, both ends included."""
    t = np.linspace(0.0, 1.0, SAMPLES + 1)[:, None]
    weights = np.concatenate([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], axis=1)
    points: Floats = weights @ control
    points[[0, -1]] = control[[0, -1]]  # to the last bit
    return points


def quadratic_points(control: Floats) -> Floats:
    """The same of a quadratic segment from its (3, 3) control points."""
    start, middle, end = control
    return cubic_points(np.array([start, (start + 2.0 * middle) / 3.0, (end + 2.0 * middle) / 3.0, end]))


def joined(pieces: list[Floats]) -> Floats:
    """Consecutive pieces as one; each begins where the one before it ends."""
    return np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])


def path_curves(name: str, pieces: list[Floats]) -> list[FileCurve]:
    """A path of consecutive pieces, lines of two points and samples of smooth segments, as curves.

    Where none of its pieces is smooth it is one polyline; else it is divided at its corners, and what has a smooth
    piece in it is smooth.
    """
    pieces = [piece for piece in pieces if (piece[0] != piece[-1]).any() or len(piece) > 2]
    if all(len(piece) == 2 for piece in pieces):
        return [FileCurve(name, joined(pieces))] if pieces else []
    runs = [[pieces[0]]]
    for piece in pieces[1:]:
        if _is_smooth(runs[-1][-1], piece):
            runs[-1].append(piece)
        else:
            runs.append([piece])
    closed = (pieces[0][0] == pieces[-1][-1]).all()
    if closed and len(runs) > 1 and _is_smooth(pieces[-1], pieces[0]):  # it starts in the middle of a run
        runs = [[*runs[-1], *runs[0]], *runs[1:-1]]
    return [
        FileCurve(name, joined(run))
        if all(len(piece) == 2 for piece in run)
        else FileCurve(name, joined([_divided(piece) for piece in run]), smooth=True)
        for run in runs
    ]


def refined(curve: FileCurve, tolerance: float) -> FileCurve:
    """A smooth curve with so many points that its chords leave it by less than a tolerance; any other as it is.

    Points halfway follow from the four around them (Dyn, Levin and Gregory 1987), which is exact on a cubic segment.
    """
    points = curve.points
    tolerance = max(tolerance, FINEST * float(np.abs(points).max()))
    while curve.smooth and len(points) > 3:
        ahead, beyond = (4.0 * p[0] - 6.0 * p[1] + 4.0 * p[2] - p[3] for p in (points, points[::-1]))
        around = np.vstack([ahead, points, beyond])
        halfway = (9.0 * (around[1:-2] + around[2:-1]) - around[:-3] - around[3:]) / 16.0
        off = float(np.abs(halfway - 0.5 * (points[1:] + points[:-1])).sum(axis=1).max())
        if not tolerance <= off < np.inf:
            break
        points = np.insert(points, np.arange(1, len(points)), halfway, axis=0)
    return FileCurve(curve.name, points.copy(), curve.smooth)


def closed_paths(curves: Sequence[FileCurve]) -> list[FileCurve]:
    """Curves of one name that follow each other up to where the first began, as one: a path with curves and corners
    is read in parts (`path_curves`), and yet encloses what it was drawn around."""
    found: list[FileCurve] = []
    for curve in curves:
        last = found[-1] if found else curve
        if last is not curve and not last.closed and last.name == curve.name and _follows(last, curve):
            found[-1] = FileCurve(last.name, joined([last.points, curve.points]), last.smooth or curve.smooth)
        else:
            found.append(curve)
    return found


def _follows(first: FileCurve, second: FileCurve) -> bool:
    return bool((first.points[-1] == second.points[0]).all())


def _is_smooth(piece: Floats, following: Floats) -> bool:
    u, v = -_leaving(piece[::-1]), _leaving(following)
    return bool(u @ v >= np.cos(SMOOTH) * np.linalg.norm(u) * np.linalg.norm(v))


def _leaving(piece: Floats) -> Floats:
    """The direction in which a piece leaves its first point, to second order in the distance of its samples."""
    if len(piece) == 2:
        return piece[1] - piece[0]
    return 4.0 * piece[1] - 3.0 * piece[0] - piece[2]


def _divided(piece: Floats) -> Floats:
    """A line within a smooth curve, with as many points as its other pieces: a spline through it stays straight."""
    if len(piece) > 2:
        return piece
    return piece[0] + np.linspace(0.0, 1.0, SAMPLES + 1)[:, None] * (piece[1] - piece[0])
