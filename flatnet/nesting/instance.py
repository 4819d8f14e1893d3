"""A published nesting problem -> pieces and a roll: the JSON of the strip packing instances of jagua-rs and sparrow."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from flatnet.pattern.labels import name_label, room_for_text
from flatnet.pattern.piece import Piece
from flatnet.project.model import Material

Floats = NDArray[np.float64]

#: The instances say no unit; theirs is taken as the power of ten mm that makes the strip at least this wide, mm, so
#: that tolerances, which are lengths of cutters, are small beside the pieces.
LEAST_WIDTH = 1000.0
#: Of one item.
MOST_COPIES = 10_000


class InstanceError(ValueError):
    """A file that is no strip packing problem; the message says why."""


def read_instance(path: Path) -> tuple[list[Piece], Material]:
    """The pieces of a strip packing problem and the roll that they go on.

    Raises
    ------
    InstanceError
        The file can't be read, or is not of that form.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        name, width = str(content["name"]), float(content["strip_height"])
        if not 1e-6 <= width <= 1e6:
            raise InstanceError(f"{path}: 'strip_height' must be in [1e-06, 1e+06], got {width:g}")
        scale = 10.0 ** max(0, math.ceil(math.log10(LEAST_WIDTH / width)))
        rotations = {_rotations(item) for item in content["items"]}
        pieces = [_piece(path, item, scale, name) for item in content["items"]]
    except OSError as error:
        raise InstanceError(f"{path}: can't be read: {error.strerror or error}") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise InstanceError(f"{path}: no strip packing problem: {type(error).__name__}: {error}") from None
    except InstanceError:
        raise
    except json.JSONDecodeError as error:
        what = "a strip packing problem is JSON; of a project, name the folder that `flatnet build` wrote"
        raise InstanceError(f"{path}: can't be read, line {error.lineno}: {error.msg}; {what}") from None
    except (ValueError, OverflowError, RecursionError) as error:
        raise InstanceError(f"{path}: can't be read: {error}") from None
    if not pieces:
        raise InstanceError(f"{path}: it has no items")
    if len({piece.name for piece in pieces}) < len(pieces):
        raise InstanceError(f"{path}: two of its items have one 'id'")
    if len(rotations) != 1:
        raise InstanceError(f"{path}: its items have different 'allowed_orientations'; a roll has one set for all")
    return pieces, Material(name, width * scale, rotations=rotations.pop())


def _rotations(item: dict[str, Any]) -> tuple[float, ...] | None:
    """Degrees; None: free, where nothing is said."""
    given = item.get("allowed_orientations")
    if given is None:
        return None
    if not np.isfinite(np.array(given, float)).all():
        raise ValueError(f"'allowed_orientations' must be finite, got {given}")
    return tuple(float(angle) for angle in given) or (0.0,)


def _piece(path: Path, item: dict[str, Any], scale: float, problem: str) -> Piece:
    name = f"item_{item['id']}"
    kind, data = item["shape"]["type"], item["shape"]["data"]
    if kind != "simple_polygon":
        raise InstanceError(f"{path}: {name}: expected a 'simple_polygon', got {kind!r}")
    outline = scale * np.array(data, float)
    if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) < 4 or not np.isfinite(outline).all():
        raise InstanceError(f"{path}: {name}: its outline is not a list of three or more points [x, y]")
    region = shapely.orient_polygons(Polygon(outline))
    if not region.is_valid:
        raise InstanceError(f"{path}: {name}: its outline is not simple: {shapely.is_valid_reason(region)}")
    demand = int(item["demand"])
    if not 1 <= demand <= MOST_COPIES:
        raise InstanceError(f"{path}: {name}: 'demand' must be in [1, {MOST_COPIES}], got {demand}")
    return plain_piece(name, np.array(region.exterior.coords)[:-1], demand, problem)


def plain_piece(name: str, outline: Floats, cut: int, material: str) -> Piece:
    """A piece of which nothing is known but its outline, anticlockwise, (n, 2) mm."""
    return Piece(
        name=name,
        sew_line=outline,
        cut_line=outline,
        holes=(),
        allowances=np.zeros(len(outline)),
        seams=(),
        notches=(),
        marks=(),
        grain=None,
        one_way=False,
        label=name_label(name, (), room_for_text(Polygon(outline), ())),
        cut=cut,
        mirrored=0,
        material=material,
    )
