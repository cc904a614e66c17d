"""One step of the filter beside a second implementation with matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from short_drive import BEGIN, SECOND, odometry_pose
from test_covariance import matrix, random_covariance

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import diagonal
from pose_arbiter.core.estimate import Estimate, mended, moved_on, residual
from pose_arbiter.core.odometry_trail import OdometryTrail
from shirube_geometry import PlanarPose

SETTINGS = ArbiterSettings()


@pytest.fixture
def trail():
    made = OdometryTrail(SETTINGS)
    for k in range(101):
        made.add(BEGIN + k * SECOND // 50, odometry_pose(k / 50))
    return made


def start(trail, noise=None, **more):
    return Estimate(trail.mark_at(BEGIN), 1.0, 2.0, 0.5, noise or diagonal(1e-4, 1e-4), **more)


def test_the_pose_goes_as_odometry_goes(trail):
    end = moved_on(start(trail), trail.mark_at(BEGIN + 2 * SECOND), SETTINGS)
    true = PlanarPose(1.0, 2.0, 0.5) @ odometry_pose(0.0).inverse() @ odometry_pose(2.0)
    assert (end.x, end.y, end.yaw) == pytest.approx((true.x, true.y, true.yaw), abs=1e-9)


def test_many_steps_are_one(trail):
    one = moved_on(start(trail), trail.mark_at(BEGIN + 2 * SECOND), SETTINGS)
    many = start(trail)
    for k in range(1, 101):
        many = moved_on(many, trail.mark_at(BEGIN + k * SECOND // 50), SETTINGS)
    assert many[1:4] == pytest.approx(one[1:4], abs=1e-9)
    assert many.covariance[5] == pytest.approx(one.covariance[5])
    assert many.covariance == pytest.approx(one.covariance, rel=0.01, abs=1e-6)


@pytest.mark.parametrize('seed', range(8))
def test_a_measurement_without_lasting_errors_does_what_kalman_says(trail, seed):
    p, r = random_covariance(seed), random_covariance(seed + 50)
    before = start(trail, p)
    d = np.random.default_rng(seed).normal(size=3) * 0.1
    after = mended(before, tuple(d), r, 0.0)
    P, R = matrix(p), matrix(r)
    information = np.linalg.inv(P) + np.linalg.inv(R)
    np.testing.assert_allclose(matrix(after.covariance), np.linalg.inv(information), atol=1e-9)
    x = np.linalg.solve(information, np.linalg.solve(R, d))
    np.testing.assert_allclose(np.array(after[1:4]) - np.array(before[1:4]), x, atol=1e-9)


def test_what_lasts_is_not_averaged_away(trail):
    noise = diagonal(1e-4, 1e-4)
    after = start(trail, diagonal(1.0, 1.0))
    for _ in range(1000):
        after = mended(after, (0.0, 0.0, 0.0), noise, 0.25)
    for variance in (after.covariance[0], after.covariance[5]):
        assert 0.2499e-4 < variance < 0.5e-4


def test_it_is_less_sure_while_it_hears_nothing(trail):
    sigmas = [
        math.sqrt(moved_on(start(trail), trail.mark_at(BEGIN + s * SECOND), SETTINGS).covariance[0])
        for s in (1, 2, 4, 8)
    ]
    assert sigmas == sorted(sigmas)
    assert sigmas[-1] > 2.0


def test_a_residual_takes_the_short_way_around(trail):
    estimate = start(trail)._replace(yaw=3.1)
    assert residual(estimate, 1.0, 2.0, -3.1)[2] == pytest.approx(math.tau - 6.2)
