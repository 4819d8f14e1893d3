"""DXF: lines, polylines, arcs, circles, ellipses and splines of the model space."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flatnet.project.drawings.file_curve import (
    DrawingError,
    FileCurve,
    Floats,
    cubic_points,
    path_curves,
    quadratic_points,
)

_ENTITIES = "LINE LWPOLYLINE POLYLINE ARC CIRCLE ELLIPSE SPLINE"


def read_dxf(file: Path) -> list[FileCurve]:
    """Every such entity, named by its layer; blocks are not looked into.

    Needs ezdxf.
    """
    try:
        import ezdxf
        from ezdxf.path import Curve3To, Curve4To, make_path
    except ModuleNotFoundError as error:
        raise DrawingError(f"reading DXF needs {error.name}: pip install ezdxf") from None
    try:
        document = ezdxf.readfile(file)
    except (ezdxf.DXFError, UnicodeDecodeError, ValueError) as error:
        raise DrawingError(f"no DXF that can be read: {error}") from None
    curves = []
    for entity in document.modelspace().query(_ENTITIES):
        try:
            path = make_path(entity)
        except (TypeError, ValueError):  # a polyface mesh is a POLYLINE too
            continue
        for part in path.sub_paths():
            pieces: list[Floats] = []
            here = np.array(part.start)
            for command in part.commands():
                end = np.array(command.end)
                if isinstance(command, Curve4To):
                    pieces.append(cubic_points(np.array([here, command.ctrl1, command.ctrl2, end])))
                elif isinstance(command, Curve3To):
                    pieces.append(quadratic_points(np.array([here, command.ctrl, end])))
                else:
                    pieces.append(np.array([here, end]))
                here = end
            curves += path_curves(entity.dxf.layer, pieces)
    return curves
