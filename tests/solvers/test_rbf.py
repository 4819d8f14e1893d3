"""The triharmonic map against SciPy's interpolator, and what it reproduces exactly."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from flatnet.solvers.rbf import fit_mirrored, fit_triharmonic


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


def mirrored(rng, on_plane, pairs):
    """Centres on the plane z = 0 and in pairs at different distances from it."""
    plane = np.c_[rng.normal(size=(on_plane, 2)), np.zeros(on_plane)]
    above = np.c_[rng.normal(size=(pairs, 2)), rng.uniform(0.1, 1.0, pairs)]
    return np.concatenate([plane, above, above * [1.0, 1.0, -1.0]])


def test_mirrored_centres_equal_scipy_on_the_plane():
    """Whatever the values are: those of a pair need not mirror each other."""
    rng = np.random.default_rng(4)
    centres = mirrored(rng, 30, 20)
    values, points = rng.normal(size=(70, 3)), np.c_[rng.normal(size=(25, 2)), np.zeros(25)]
    expected = RBFInterpolator(centres, values, kernel="cubic", degree=1)(points)
    np.testing.assert_allclose(fit_mirrored(centres, values)(points), expected, atol=1e-9)


def test_mirrored_centres_reproduce_affine_maps_far_from_the_origin():
    rng = np.random.default_rng(5)
    away = np.array([1e4, 1e4, 0.0])
    centres, points = mirrored(rng, 30, 20) + away, np.c_[rng.normal(size=(10, 2)), np.zeros(10)] + away
    matrix, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
    mapping = fit_mirrored(centres, centres @ matrix + shift)
    np.testing.assert_allclose(mapping(points), points @ matrix + shift, atol=1e-7)


def test_mirrored_centres_that_repeat_or_lie_on_a_line_show_in_the_condition():
    rng = np.random.default_rng(6)
    centres = mirrored(rng, 30, 20)
    centres[7] = centres[3]
    assert not fit_mirrored(centres, centres).reciprocal_condition > 1e-15
    centres = mirrored(rng, 30, 20) * [1.0, 0.0, 1.0]
    assert not fit_mirrored(centres, centres).reciprocal_condition > 1e-15


def test_centres_without_their_mirror_images_are_refused():
    centres = mirrored(np.random.default_rng(7), 30, 20)
    centres[-1, 0] += 1e-9
    with pytest.raises(ValueError, match="mirrored"):
        fit_mirrored(centres, centres)
