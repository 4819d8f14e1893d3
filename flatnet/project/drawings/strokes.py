"""JSON: strokes of cubic Bezier segments between nodes, as CASSIE and its successors write curve networks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from flatnet.geometry.polygon import polyline_length
from flatnet.project.drawings.file_curve import DrawingError, FileCurve, Floats, cubic_points, joined

#: How far a segment may end from its node, over its length, before the file is taken for damaged.
_FARTHEST_END = 0.01


def read_strokes(file: Path) -> list[FileCurve]:
    """Every stroke as one curve, or several where its segments do not follow each other.

    The file is an object with `strokes` (`id`, `segments`), `segments` (`id`, `ctrl_pts`: a list of cubics of four
    points or lines of two, `nodes`: two ids) and `nodes` (`id`, `position`).
    """
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        nodes = {node["id"]: _array(node["position"], 3) for node in content["nodes"]}
        segments = {segment["id"]: _segment(segment, nodes) for segment in content["segments"]}
        strokes = [(str(stroke["id"]), stroke["segments"]) for stroke in content["strokes"]]
        return [
            FileCurve(f"stroke_{name}", points, smooth=True)
            for name, members in strokes
            for points in _runs([segments[member] for member in members])
        ]
    except json.JSONDecodeError as error:
        raise DrawingError(f"line {error.lineno}: no valid JSON: {error.msg}") from None
    except (KeyError, TypeError, IndexError) as error:
        raise DrawingError(f"no network of strokes, segments and nodes: {type(error).__name__} {error}") from None


def _array(value: Any, *shape: int) -> Floats:
    try:
        array = np.array(value, dtype=float)
    except (ValueError, TypeError):
        array = np.zeros(0)
    if array.shape != shape:
        raise DrawingError(f"expected {' x '.join(map(str, shape))} numbers, got {str(value)[:60]}")
    return array


def _segment(segment: dict[str, Any], nodes: dict[Any, Floats]) -> Floats:
    """Points of a segment, from node to node to the last bit."""
    pieces = []
    for control in segment["ctrl_pts"]:
        if len(control) == 2:
            pieces.append(_array(control, 2, 3))
        else:
            pieces.append(cubic_points(_array(control, 4, 3)))
    points = joined(pieces)
    first, last = (nodes[node] for node in segment["nodes"])
    length = polyline_length(points)
    for end, node in ((points[0], first), (points[-1], last)):
        if np.linalg.norm(end - node) > _FARTHEST_END * length:
            raise DrawingError(f"segment {segment['id']} does not end at its nodes")
    points[0], points[-1] = first, last
    return points


def _runs(pieces: list[Floats]) -> list[Floats]:
    """Pieces that follow each other as one."""
    runs: list[list[Floats]] = []
    for piece in pieces:
        if runs and (runs[-1][-1][-1] == piece[0]).all():
            runs[-1].append(piece)
        else:
            runs.append([piece])
    return [joined(run) for run in runs]
