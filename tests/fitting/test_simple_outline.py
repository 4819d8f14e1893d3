"""`planar_boundary: simple`: an outline that the normals make cross itself is opened, no more than it must be."""

from dataclasses import replace

import numpy as np
import pytest
from crossing import omega

from flatnet.failure import PatchFailure
from flatnet.fitting.planar_boundary import BOUND_ACCURACY, fit_planar_boundary
from flatnet.fitting.results import FittedPatch
from flatnet.fitting.run import run_patch
from flatnet.geometry.crossings import polygon_crossings
from flatnet.geometry.polygon import side_lengths
from flatnet.parameters import FairParameters
from flatnet.solvers.angle_program import solve_angle_program


def test_it_is_opened_as_little_as_removes_the_crossing():
    boundary = omega().boundary
    with pytest.raises(PatchFailure) as crossed:
        fit_planar_boundary(boundary)
    assert crossed.value.finding.code == "self_intersection"
    opened = fit_planar_boundary(boundary, simple=True)
    assert polygon_crossings(opened.positions) == []
    np.testing.assert_allclose(side_lengths(opened.positions), side_lengths(boundary.vertices), rtol=1e-12)
    [warning] = opened.warnings
    assert warning.code == "outline_opened" and warning.amount == pytest.approx(opened.angle_error)
    # A bound larger by a little more than the accuracy lets it cross.
    bound = opened.inner_angles.max() + 1.1 * BOUND_ACCURACY
    lower, upper = opened.lower_bounds, np.maximum(opened.lower_bounds, bound)
    wider = solve_angle_program(opened.predicted_angles, side_lengths(boundary.vertices), lower, upper)
    assert polygon_crossings(wider.positions, boundary.vertices)
    assert np.mean((wider.angles - opened.predicted_angles) ** 2) < opened.angle_error


def test_the_patch_is_made_with_it_and_not_without():
    patch = omega()
    assert run_patch(patch, FairParameters()).failure.code == "self_intersection"
    made = run_patch(replace(patch, simple_outline=True), FairParameters())
    assert isinstance(made, FittedPatch)
    assert "outline_opened" in [warning.code for warning in made.warnings]


def test_an_outline_that_does_not_cross_itself_stays_as_it_is():
    boundary = omega(tilt=0.0).boundary
    np.testing.assert_array_equal(
        fit_planar_boundary(boundary, simple=True).positions, fit_planar_boundary(boundary).positions
    )
