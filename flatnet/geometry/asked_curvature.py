"""The curvature that the edge normals of a boundary ask for, and how far a surface without any must leave them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from flatnet.geometry.polygon import polygon_angles

Floats = NDArray[np.float64]

#: A boundary that turns back by 180 degrees less this, rad, does so whatever its normals: the tip of a slit.
TURNS_BACK = 1e-6
#: Total turning this near to 2 pi is 2 pi, rad; what is left is round-off of many angles.
ROUND_OFF = 1e-9


def asked_curvature(predicted: Floats) -> float:
    """Total Gaussian curvature of a disk whose inner angles along its boundary are `predicted`, (n,), rad.

    Gauss-Bonnet: the integral of K is 2 pi less the turning of the boundary, so it is sum(alpha) - (n - 2) pi;
    positive for a dome, negative for a saddle, 0 for what can be unfolded.
    """
    return float(predicted.sum() - (len(predicted) - 2) * np.pi)


def least_normal_deviation(vertices: Floats, predicted: Floats) -> float:
    """The angle, rad, by which some normals at least give way on a smooth surface without curvature.

    At a vertex the boundary turns by kappa, within the surface by kappa cos(phi) = pi - alpha, where phi is the angle
    between the direction it turns to and the surface. Normals that are nowhere turned by more than delta change phi
    by no more than delta. So a dome's boundary, which turns by less than the 2 pi of a flat piece, turns by
    sum kappa cos(max(phi - delta, 0)) at the most; a saddle's, which turns by more, by
    sum kappa cos(min(phi + delta, pi)) at the least. The result is the delta where this is 2 pi.

    It is a bound from below: curvature that is asked for in one place and taken back in another does not show.

    Parameters
    ----------
    vertices : (n, 3) float; the closed boundary.
    predicted : (n,) float, rad; alpha of Fig. 3.
    """
    in_surface = np.pi - predicted
    kappa = np.maximum(np.pi - polygon_angles(vertices), np.abs(in_surface))
    phi = np.arccos(in_surface / np.maximum(kappa, np.finfo(float).tiny))
    sense = np.sign(asked_curvature(predicted))
    held = kappa > np.pi - TURNS_BACK

    def still_asked(delta: float) -> float:
        turned = np.where(held, phi, np.clip(phi - sense * delta, 0.0, np.pi))
        return sense * float(2.0 * np.pi - kappa @ np.cos(turned)) - ROUND_OFF

    if still_asked(0.0) <= 0.0:
        return 0.0
    # Fully turned, a boundary turns by its total curvature, at least 2 pi (Fenchel), or by as much the other way.
    return float(brentq(still_asked, 0.0, np.pi, xtol=1e-9)) if still_asked(np.pi) < 0.0 else np.pi
