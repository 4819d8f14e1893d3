"""The triharmonic map against SciPy's interpolator, and what it reproduces exactly."""

import numpy as np
from scipy.interpolate import RBFInterpolator

from flatnet.solvers.rbf import fit_triharmonic


def test_equals_scipy():
    rng = np.random.default_rng(1)
    centres, values, points = rng.normal(size=(40, 3)), rng.normal(size=(40, 3)), rng.normal(size=(20, 3))
    expected = RBFInterpolator(centres, values, kernel="cubic", degree=1)(points)
    np.testing.assert_allclose(fit_triharmonic(centres, values)(points), expected, atol=1e-9)


def test_reproduces_affine_maps_far_from_the_origin():
    rng = np.random.default_rng(2)
    centres = 1e4 + rng.normal(size=(30, 3))
    matrix, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
    points = 1e4 + 3.0 * rng.normal(size=(10, 3))
    mapping = fit_triharmonic(centres, centres @ matrix + shift)
    # Coordinates of 1e4 have 1e-12 of round-off; the system's condition takes a few digits more.
    np.testing.assert_allclose(mapping(points), points @ matrix + shift, atol=1e-7)


def test_coplanar_centres_show_in_the_condition():
    rng = np.random.default_rng(3)
    centres = np.c_[rng.normal(size=(30, 2)), np.zeros(30)]
    assert fit_triharmonic(centres, centres).reciprocal_condition < 1e-15
