"""In which rotations a piece fits on its material, and what to say where it fits in none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from flatnet.failure import Finding
from flatnet.nesting.check import TOLERANCE
from flatnet.nesting.layout import turn, turned_by
from flatnet.pattern.piece import Piece
from flatnet.project.model import Material

Floats = NDArray[np.float64]

#: Degrees between the rotations tried where rotation is free, besides those that lay a side along the roll.
FREE_STEP = 15.0


def candidate_rotations(piece: Piece, mirrored: bool, material: Material) -> Floats:
    """The rotations to try, degrees: the allowed ones; where all are, a choice with the narrowest among them.

    A convex outline is narrowest with one of its sides along the roll (rotating callipers), so the sides of
    the hull are among the free rotations.
    """
    if material.rotations is not None:
        return np.array(material.rotations)
    hull = shapely.get_coordinates(shapely.convex_hull(piece.region)) @ turn(0.0, mirrored).T
    sides = np.diff(hull, axis=0)
    along = -np.degrees(np.arctan2(sides[:, 1], sides[:, 0])) % 360.0
    return np.unique(np.concatenate([np.arange(0.0, 360.0, FREE_STEP), along, (along + 90.0) % 360.0]))


def extents(piece: Piece, mirrored: bool, rotations: Floats) -> Floats:
    """Size along and across the roll in each rotation, (k, 2), mm."""
    hull = shapely.get_coordinates(shapely.convex_hull(piece.region))
    return np.array([np.ptp(hull @ turn(angle, mirrored).T, axis=0) for angle in rotations])


def fitting_rotations(piece: Piece, mirrored: bool, material: Material) -> Floats:
    """Those of the candidate rotations in which the piece fits on the material, degrees.

    Of a piece whose copies are to match it is the first that all of them have in common.
    """
    rotations = _fitting(piece, mirrored, material, candidate_rotations(piece, mirrored, material))
    if not piece.match:
        return rotations
    if piece.cut and piece.mirrored:
        others = candidate_rotations(piece, not mirrored, material)
        rotations = np.intersect1d(rotations, _fitting(piece, not mirrored, material, others))
    return rotations[:1]


def _fitting(piece: Piece, mirrored: bool, material: Material, rotations: Floats) -> Floats:
    size = extents(piece, mirrored, rotations)
    length = np.inf if material.length is None else material.length
    return rotations[(size <= np.array([length, material.width]) + 0.5 * TOLERANCE).all(axis=1)]


def fits_anyhow(piece: Piece, material: Material) -> bool:
    """Whether the piece fits in every rotation there is."""
    room = material.width if material.length is None else min(material.width, material.length)
    return 2.0 * float(shapely.minimum_bounding_radius(piece.region)) <= room


def _off_the_grain(piece: Piece, mirrored: bool, material: Material) -> str:
    """The rotation nearest to an allowed one in which the piece would fit, in words; "" where there is none."""
    free = replace(material, rotations=None)
    fitting = _fitting(piece, mirrored, material, candidate_rotations(piece, mirrored, free))
    if material.rotations is None or not len(fitting):
        return ""
    away = [min(turned_by(angle, allowed) for allowed in material.rotations) for angle in fitting.tolist()]
    return f"Turned by {fitting[np.argmin(np.round(away, 6))]:.4g} degrees against its grain it would fit. "


def too_large(piece: Piece, material: Material) -> Finding | None:
    """`sheet_too_small` for a piece of which a copy fits in no allowed rotation, with both numbers."""
    kinds = [False] * (piece.cut > 0) + [True] * (piece.mirrored > 0)
    for mirrored in kinds:
        if len(fitting_rotations(piece, mirrored, material)):
            continue
        size = extents(piece, mirrored, candidate_rotations(piece, mirrored, material))
        across = float(size[:, 1].min())
        if across > material.width:
            what, needed, room = "wide", across, material.width
        else:  # narrow enough in some rotation, and too long in each of those
            what, room = "long", float(material.length or np.inf)
            needed = float(size[size[:, 1] <= material.width + 0.5 * TOLERANCE, 0].min())
        return Finding(
            code="sheet_too_small",
            stage="nesting",
            patch=piece.name,
            amount=needed,
            unit="mm",
            message=f"with its allowance the piece is at least {needed:.1f} mm {what} in every allowed "
            f"rotation, and material '{material.name}' is {room:.1f} mm.",
            remedy=f"{_off_the_grain(piece, mirrored, material)}Divide the patch, allow other rotations, or take a "
            f"material that is {what} enough.",
        )
    return None
