"""Geometry and disparities of horizontal and vertical pairs."""

import math

import numpy as np
import pytest
from l_rig import CAMERA, picture, projection, true_depth

from reward_planner.core.depth.stereo_pair import PairMatcher, StereoPair, pair_from_projections
from reward_planner.core.depth.trinocular_depth import depth_from_disparity
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import DepthSettings
from shirube_core.geometry import PinholeCamera


@pytest.mark.parametrize(('x', 'y'), [(0.1, 0.0), (-0.12, 0.0), (0.0, 0.08), (0.0, -0.1)])
def test_the_baseline_is_the_position_of_the_other_camera_and_a_point_moves_by_the_disparity(x, y):
    pair = pair_from_projections(projection(), projection(x=x, y=y))
    assert pair.axis == (0 if x else 1)
    assert pair.baseline == pytest.approx(x + y)
    assert pair.focal_baseline == pytest.approx(262.5 * abs(x + y))
    point = np.array([0.3, -0.2, 2.0, 1.0])
    left, other = (P @ point / (P @ point)[2] for P in (projection(), projection(x=x, y=y)))
    moved = left[pair.axis] - other[pair.axis]
    assert moved == pytest.approx(pair.sign * pair.focal_baseline / 2.0 + pair.offset)


def changed(row, column, value):
    P = projection(x=0.1)
    P[row, column] = value
    return P


@pytest.mark.parametrize(
    ('other', 'words'),
    [
        (projection(), 'no baseline'),
        (changed(1, 3, -20.0), 'neither a horizontal nor a vertical pair'),
        (changed(1, 2, 125.0), 'principal points'),
        (changed(0, 0, 270.0), 'focal lengths or shears differ'),
        (changed(0, 1, 3.0), 'focal lengths or shears differ'),
        (changed(0, 3, math.nan), 'not a projection matrix'),
        (np.eye(3), 'not a projection matrix'),
        (np.zeros((3, 4)), 'not a projection matrix'),
    ],
)
def test_cameras_that_are_no_rectified_pair_are_refused(other, words):
    with pytest.raises(RewardPlannerError, match=words) as error:
        pair_from_projections(projection(), other)
    assert '\n' not in str(error.value)


def test_a_shifted_principal_point_is_an_offset():
    shifted = projection(PinholeCamera(320, 240, 262.5, 262.5, 163.5, 119.5), x=0.1)
    assert pair_from_projections(projection(), shifted).offset == pytest.approx(-4.0)


SETTINGS = DepthSettings(disparities=48)


def disparities(x=0.0, y=0.0, settings=SETTINGS):
    pair = pair_from_projections(projection(), projection(x=x, y=y))
    return PairMatcher(pair, settings).match(picture(), picture(x, y)), pair


@pytest.mark.parametrize(
    ('x', 'y', 'matcher', 'covered'),
    [
        *[(x, y, 'sgbm', 0.7) for x, y in ((0.1, 0.0), (-0.1, 0.0), (0.0, -0.1), (0.0, 0.1))],
        (0.1, 0.0, 'bm', 0.4),  # blocks match less, but where they do rightly
    ],
)
def test_disparities_are_those_of_the_true_depth(x, y, matcher, covered):
    found, pair = disparities(x, y, DepthSettings(disparities=48, matcher=matcher))
    matched = np.isfinite(found)
    assert matched.mean() > covered
    error = np.abs(found - pair.focal_baseline / true_depth())[matched]
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


def test_images_that_do_not_fit_and_settings_without_a_matcher_are_refused():
    pair, grey = pair_from_projections(projection(), projection(x=0.1)), np.zeros((240, 320), np.uint8)
    colour = np.zeros((240, 320, 3), np.uint8)
    for left, other in ((colour, colour), (grey, grey[:, 1:]), (grey.astype(np.float32),) * 2):
        with pytest.raises(RewardPlannerError, match='grey ones of the same size'):
            PairMatcher(pair, SETTINGS).match(left, other)
    for settings in (DepthSettings(disparities=50), DepthSettings(block=4)):
        with pytest.raises(RewardPlannerError, match='multiple of 16'):
            PairMatcher(pair, settings)
