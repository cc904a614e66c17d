import math
from dataclasses import replace

import numpy as np
import pytest
from lamp_room import BEACONS, CAMERA, MOUNT, normalised_square, pixels_of

from shirube_core.geometry import SE2, gravity_aligned_camera
from vlc_beacon.core.pose.lamp_rays import lamp_rays
from vlc_beacon.core.pose.pose_filter import PoseFilter
from vlc_beacon.core.settings import PoseSettings

EXACT = PoseSettings(pixel_sigma=0.0, beacon_sigma=0.0, tilt_sigma=0.0)
START = np.diag([0.01**2, 0.01**2, 0.01**2, 0.01**2])
TRUTH = SE2(0.8, 1.0, 0.4)
LEVEL = gravity_aligned_camera(MOUNT)


def seen(pose, which, noise=0.2, rng=None):
    """Return the rays and places of some lamps."""
    beacons = [BEACONS[i] for i in which]
    pixels = pixels_of(beacons, pose) + (0.0 if rng is None else noise * rng.normal(size=(len(beacons), 2)))
    rays = lamp_rays(CAMERA, [b.id for b in beacons], pixels, np.full(len(beacons), noise))
    return rays, np.array([b.xyz for b in beacons])


def filter_at(pose, settings=None, covariance=START):
    return PoseFilter(pose, 0.0, covariance, settings)


def test_odometry_alone_composes_motions_and_loses_certainty():
    start = expected = SE2(1.0, 2.0, 0.3)
    filter_, traces = filter_at(start), []
    for _ in range(50):
        step = SE2(0.1, 0.0, 0.05)
        expected = expected @ step
        filter_.predict(step)
        traces.append(np.trace(filter_.covariance[:2, :2]))
    assert filter_.pose.distance_to(expected) < 1e-9
    assert filter_.pose.yaw_to(expected) == pytest.approx(0.0, abs=1e-9)
    assert traces == sorted(traces)
    # After 5 m the way is off by 2 % and more.
    assert math.sqrt(traces[-1]) > 0.02 * filter_.pose.distance_to(start)


def test_lamps_pull_the_pose_to_the_truth():
    filter_ = PoseFilter(TRUTH @ SE2(0.015, -0.01, 0.008), 0.01, START, EXACT)
    for _ in range(100):
        assert filter_.update(*seen(TRUTH, range(4)), LEVEL).all()
    assert filter_.pose.distance_to(TRUTH) < 1e-3
    assert filter_.height == pytest.approx(0.0, abs=1e-3)


def test_one_lamp_reduces_the_observable_errors():
    filter_ = filter_at(TRUTH, EXACT)
    before = filter_.covariance
    filter_.update(*seen(TRUTH, [0]), LEVEL)
    after = filter_.covariance
    assert (np.linalg.eigvalsh(before - after) > -1e-12).all()
    gains = np.linalg.eigvalsh(np.linalg.inv(after) - np.linalg.inv(before))
    assert (gains[:2] < 1e-3 * gains[2]).all()


def test_errors_match_the_covariance():
    rng = np.random.default_rng(1)
    normalised = []
    for _ in range(60):
        pose = SE2(0.9, 0.5, 0.2)
        start = SE2(*(np.array([pose.x, pose.y, pose.yaw]) + 0.01 * rng.normal(size=3)))
        filter_ = PoseFilter(start, 0.01 * rng.normal(), START, EXACT)
        scale, bend = 1.0 + 0.02 * rng.normal(), 0.0035 * rng.normal()
        for k in range(30):
            pose = pose @ SE2(0.02, 0.0, 0.01)
            filter_.predict(SE2(0.02 / scale, 0.0, 0.01 - bend * 0.02))
            if k % 3 == 0:
                filter_.update(*seen(pose, [k % 4], rng=rng), LEVEL)
        normalised.append(normalised_square(filter_.pose, filter_.covariance[:2, :2], pose))
    # The filter allows for slip, which this odometry does not have.
    assert 0.2 < np.mean(normalised) < 1.3


@pytest.mark.parametrize(
    ('seed', 'runs', 'images', 'step', 'noise', 'low', 'high'),
    [(2, 16, 150, SE2(0.004, 0.0, 0.005), 0.1, 0.75, 1.15), (5, 5, 700, SE2(0.0, 0.0, 0.0), 0.0, 0.0, 1.5)],
    ids=['on a short way', 'stationary'],
)
@pytest.mark.newest_set_only
def test_biases_match_the_covariance(seed, runs, images, step, noise, low, high):
    """Lamps that hang a little elsewhere and a mount that leans: many images of them say nothing new."""
    rng, settings, lamps = np.random.default_rng(seed), PoseSettings(), np.array([b.xyz for b in BEACONS])
    squares = []
    for _ in range(runs):
        shifted = [replace(b, xyz=tuple(b.xyz + settings.beacon_sigma * rng.normal(size=3))) for b in BEACONS]
        tilt = settings.tilt_sigma * rng.normal(size=2)
        pose = SE2(0.7, 0.7, rng.uniform(-3.0, 3.0)) if noise else SE2(0.9, 0.9, 0.3)
        filter_ = filter_at(pose @ SE2(*(0.01 * rng.normal(size=3))), settings)
        for _ in range(images):
            pixels = pixels_of(shifted, pose, tilt=tilt) + (noise and noise * rng.normal(size=(4, 2)))
            rays = lamp_rays(CAMERA, [b.id for b in BEACONS], pixels, np.full(4, noise or 0.2))
            assert filter_.update(rays, lamps, LEVEL).all() or noise
            filter_.predict(step)
            pose = pose @ step
        squares.append(normalised_square(filter_.pose, filter_.covariance[:2, :2], pose))
    assert low < math.sqrt(np.mean(squares)) < high


def test_a_lamp_in_the_wrong_place_is_left_out():
    filter_ = filter_at(TRUTH)
    rays, lamps = seen(TRUTH, range(4))
    lamps[2, 0] += 0.3
    assert filter_.update(rays, lamps, LEVEL).tolist() == [True, True, False, True]
    assert filter_.pose.distance_to(TRUTH) < 1e-3


@pytest.mark.parametrize(
    ('bias', 'lamps', 'least'),
    [({'beacon_sigma': 0.01}, 4, 0.003), ({'pixel_sigma': 1.0}, 4, 0.001), ({'tilt_sigma': 0.01}, 1, 0.008)],
)
def test_a_stationary_robot_does_not_average_out_biases(bias, lamps, least):
    filter_ = filter_at(TRUTH, replace(EXACT, **bias))
    for _ in range(60):
        filter_.update(*seen(TRUTH, range(lamps)), LEVEL)
    # Four lamps with 1 cm each do not give 1 mm, however often they are looked at.
    assert math.sqrt(filter_.covariance[0, 0]) > least


@pytest.mark.newest_set_only
def test_a_turn_on_the_spot_after_long_rest_is_followed():
    """Odometry that turns 2 % too far: lamps must still correct the heading."""
    pose = SE2(0.9, 0.9, 0.0)
    filter_ = filter_at(pose)
    for k in range(650):
        if k >= 350:
            pose = pose @ SE2(0.0, 0.0, 0.01)
            filter_.predict(SE2(0.0, 0.0, 0.0102))
        assert filter_.update(*seen(pose, range(4)), LEVEL).all()
    assert filter_.pose.yaw_to(pose) == pytest.approx(0.0, abs=0.005)
    assert filter_.pose.distance_to(pose) < 0.005


@pytest.mark.newest_set_only
def test_a_new_lamp_is_used_by_a_stationary_robot():
    filter_ = filter_at(TRUTH, None, 25.0 * START)
    for _ in range(320):
        filter_.update(*seen(TRUTH, [0]), LEVEL)
    before = filter_.covariance
    for _ in range(200):
        filter_.update(*seen(TRUTH, range(4)), LEVEL)
    assert np.trace(filter_.covariance[:2, :2]) < 0.1 * np.trace(before[:2, :2])
