from dataclasses import replace

import cv2
import numpy as np
import pytest
from drawn_wall import Disc, Wall, from_left, look, teach_view, view_of
from taught_wall import RIG

from stereo_landmark.core.features.patch_alignment import align_patches, cut_patches, smooth
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.settings import BOTH, FEATURES, SHAPES, LandmarkSettings, SearchSettings

RNG = np.random.default_rng(0)
METERS = tuple(Disc(y, 0.8, 0.1, 40.0) for y in (0.6, 0.1, -0.4))
DISCS = tuple(
    Disc(y, z, float(size), float(level))
    for y, z, size, level in zip(
        RNG.uniform(-1.2, 1.2, 120),
        RNG.uniform(0.0, 1.6, 120),
        RNG.uniform(0.015, 0.04, 120),
        RNG.uniform(30.0, 230.0, 120),
        strict=True,
    )
)
WALL = Wall((*DISCS, *METERS))
STATE = np.array([0.15, -0.1, 0.0, 0.08, 0.0, 0.0])


@pytest.fixture(scope='module')
def place():
    view = view_of(WALL, np.zeros(6))
    meters = [each for each in from_left(view) if each.semi_axes[0] > 10.0]
    return teach_view(view, {f'meter {i}': each for i, each in enumerate(meters)})


def locate(place, state=STATE, tilt=(0.0, 0.0), wall=WALL, **settings):
    return LandmarkLocalizer([place], LandmarkSettings(**settings)).locate(*look(wall, state), tilt)


def error_of(fix, state=STATE):
    """Return the errors of x, y, z [m] and yaw [rad]."""
    assert isinstance(fix, LandmarkFix)
    pose = fix.displacement.T_place_base
    return np.array([pose.x, pose.y, fix.displacement.height, pose.yaw]) - state[:4]


def test_a_patch_is_found_to_a_twentieth_of_a_pixel_whatever_gain_and_offset():
    image = cv2.GaussianBlur(np.random.default_rng(1).uniform(0.0, 200.0, (120, 160)), (0, 0), 2.0)
    shift = np.float32([[1.0, 0.0, 0.6], [0.0, 1.0, -0.35]])
    moved = 0.7 * cv2.warpAffine(image, shift, (160, 120), flags=cv2.INTER_CUBIC) + 20.0
    centres = np.random.default_rng(2).uniform(25.0, 95.0, (30, 2))
    maps = np.tile(np.eye(2), (30, 1, 1))
    patches = cut_patches(smooth(image), centres)
    found = align_patches(patches, np.arange(30), smooth(moved), centres, maps)
    assert np.median(np.abs(found.pixels - centres - [0.6, -0.35])) < 0.05
    assert (found.correlations > 0.95).all()


@pytest.mark.parametrize('method', [FEATURES, BOTH])
def test_the_error_is_as_large_as_stated(place, method):
    fix = locate(place, method=method)
    assert (np.abs(error_of(fix)) <= 4.0 * np.sqrt(fix.displacement.covariance.diagonal())).all()
    assert fix.displacement.feature_count > 20


def test_a_tilt_that_is_three_degrees_wrong_costs_nothing(place):
    fix = locate(place, tilt=(0.052, -0.052))
    assert (np.abs(error_of(fix)) <= [0.01, 0.01, 0.01, 0.005]).all()


def test_the_view_finds_where_all_targets_are_hidden(place):
    hidden = Wall(DISCS)
    assert not isinstance(locate(place, wall=hidden, method=SHAPES), LandmarkFix)
    assert np.linalg.norm(error_of(locate(place, wall=hidden))[:3]) < 0.01


def test_another_wall_is_refused(place):
    discs = tuple(replace(each, y=-each.y, z=1.6 - each.z) for each in DISCS)
    assert not isinstance(locate(place, wall=Wall(discs)), LandmarkFix)


@pytest.mark.parametrize('method', [FEATURES, BOTH])
def test_another_wall_that_shares_a_part_of_the_texture_is_refused(place, method):
    """As where two walls have the same wallpaper."""
    shared = [each for each in DISCS if each.y < -0.1]
    others = [replace(each, z=1.6 - each.z) for each in DISCS if each.y >= -0.1]
    assert not isinstance(locate(place, wall=Wall((*shared, *others)), method=method), LandmarkFix)


def test_a_pose_outside_of_the_search_region_is_refused(place):
    answer = locate(place, search=SearchSettings(distance_max=0.1))
    assert not isinstance(answer, LandmarkFix)


def test_a_place_without_images_is_found_by_its_shapes(place):
    fix = locate(replace(place, images=None, pair=None))
    assert fix.displacement.feature_count == 0
    assert np.linalg.norm(error_of(fix)[:3]) < 0.01


def test_a_new_calibration_keeps_the_features_in_space(place):
    other = replace(place, rig=replace(RIG, baseline=1.02 * RIG.baseline))
    (before, after) = (each.pair.features.points.positions for each in (place, other))
    assert (before == after).all()
