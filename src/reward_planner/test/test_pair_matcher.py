"""Disparities of pairs in all four directions, against the true depth of a rendered room."""

from __future__ import annotations

import numpy as np
import pytest
from l_rig import CAMERA, picture, projection, true_depth

from reward_planner.core.depth.depth_settings import DepthSettings
from reward_planner.core.depth.stereo_pair import PairMatcher, StereoPair, pair_from_projections
from reward_planner.core.depth.trinocular_depth import depth_from_disparity
from reward_planner.core.reward_planner_error import RewardPlannerError

SETTINGS = DepthSettings(disparities=48)


def disparities(x=0.0, y=0.0, settings=SETTINGS):
    pair = pair_from_projections(projection(), projection(x=x, y=y))
    return PairMatcher(pair, settings).match(picture(), picture(x, y)), pair


@pytest.mark.parametrize(('x', 'y'), [(0.1, 0.0), (-0.1, 0.0), (0.0, -0.1), (0.0, 0.1)])
def test_disparities_are_those_of_the_true_depth(x, y):
    found, pair = disparities(x, y)
    truth = pair.focal_baseline / true_depth()
    matched = np.isfinite(found)
    assert matched.mean() > 0.7
    error = np.abs(found - truth)[matched]
    assert np.median(error) < 0.15
    assert (error > 1.0).mean() < 0.06


@pytest.mark.parametrize('direction', [(0.1, 0.0), (0.0, -0.1)])
def test_points_follow_the_printed_equations(direction):
    found, pair = disparities(*direction)
    v, u = np.mgrid[0.0 : CAMERA.height, 0.0 : CAMERA.width]
    X_left, Y_left = u - CAMERA.cx, v - CAMERA.cy
    # Eqs. (1) and (2) give the point from the midpoint of both cameras.
    X_other, Y_other = X_left - found * (pair.axis == 0), Y_left - pair.sign * found * (pair.axis == 1)
    X, Y = (abs(pair.baseline) * (a + b) / (2.0 * found) for a, b in ((X_left, X_other), (Y_left, Y_other)))
    Z = depth_from_disparity(found, pair)
    middle = 0.5 * np.array(direction)
    good = np.isfinite(found)
    assert np.allclose((X + middle[0])[good], (Z * X_left / CAMERA.fx)[good], atol=1e-5)
    assert np.allclose((Y + middle[1])[good], (Z * Y_left / CAMERA.fy)[good], atol=1e-5)


def test_blocks_match_less_but_where_they_do_rightly():
    found, pair = disparities(0.1, settings=DepthSettings(disparities=48, matcher='bm'))
    error = np.abs(found - pair.focal_baseline / true_depth())[np.isfinite(found)]
    assert len(error) > 0.4 * found.size
    assert (error > 1.0).mean() < 0.06


def test_an_offset_of_the_principal_points_is_taken_off():
    found, pair = disparities(0.1)
    shifted = StereoPair(pair.axis, pair.baseline, pair.focal_length, 4.0)
    moved = PairMatcher(shifted, SETTINGS).match(picture(), np.roll(picture(0.1), -4, axis=1))
    both = np.isfinite(found) & np.isfinite(moved)
    both[:, -60:] = False
    assert both.mean() > 0.5
    assert np.median(np.abs(found - moved)[both]) < 0.05


def test_a_plain_grey_image_has_no_depth():
    grey = np.full((240, 320), 90, dtype=np.uint8)
    pair = pair_from_projections(projection(), projection(x=0.1))
    assert np.isnan(PairMatcher(pair, SETTINGS).match(grey, grey)).all()


@pytest.mark.parametrize(
    ('left', 'other'),
    [
        (np.zeros((240, 320, 3), np.uint8), np.zeros((240, 320, 3), np.uint8)),
        (np.zeros((240, 320), np.uint8), np.zeros((240, 319), np.uint8)),
        (np.zeros((240, 320), np.float32), np.zeros((240, 320), np.float32)),
    ],
)
def test_images_that_do_not_fit_are_refused(left, other):
    pair = pair_from_projections(projection(), projection(x=0.1))
    with pytest.raises(RewardPlannerError, match='grey ones of the same size'):
        PairMatcher(pair, SETTINGS).match(left, other)


@pytest.mark.parametrize('settings', [DepthSettings(disparities=50), DepthSettings(block=4)])
def test_settings_without_a_matcher_are_refused(settings):
    with pytest.raises(RewardPlannerError, match='multiple of 16'):
        PairMatcher(StereoPair(0, 0.1, 200.0, 0.0), settings)
