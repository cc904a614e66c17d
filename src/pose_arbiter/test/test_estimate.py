"""Filter steps against second implementations: information form, and all measurements in one batch."""

from __future__ import annotations

import math

import numpy as np
import pytest
from short_drive import BEGIN, SECOND, odometry_pose
from test_covariance import random_covariance

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import as_matrix, diagonal, scaled
from pose_arbiter.core.estimate import lasting_root, measured, mended, moved_on, residual, told
from pose_arbiter.core.odometry_trail import OdometryTrail
from shirube_geometry import PlanarPose

SETTINGS = ArbiterSettings()
SHARE = 0.4


@pytest.fixture
def trail():
    made = OdometryTrail(SETTINGS)
    for k in range(101):
        made.add(BEGIN + k * SECOND // 50, odometry_pose(k / 50))
    return made


def start(trail, noise=None, sources=2):
    return told(trail.mark_at(BEGIN), 1.0, 2.0, 0.5, noise or diagonal(1e-4, 1e-4), sources)


def difference_to(estimate, z):
    return residual(estimate, 1.0 + z[0], 2.0 + z[1], 0.5 + z[2])


def by_all_at_once(p, said):
    """Return mean and covariance of pose and biases of two sources after measurements (source, z, R)."""
    information, vector = np.eye(9), np.zeros(9)
    information[:3, :3] = np.linalg.inv(as_matrix(p))
    for source, z, r in said:
        H = np.zeros((3, 9))
        H[:, :3] = np.eye(3)
        H[:, 3 + 3 * source : 6 + 3 * source] = math.sqrt(SHARE) * lasting_root(r)
        weight = np.linalg.inv((1.0 - SHARE) * as_matrix(r))
        information += H.T @ weight @ H
        vector += H.T @ weight @ z
    return np.linalg.solve(information, vector), np.linalg.inv(information)


def test_the_pose_goes_as_odometry_goes(trail):
    end = moved_on(start(trail), trail.mark_at(BEGIN + 2 * SECOND), SETTINGS)
    true = PlanarPose(1.0, 2.0, 0.5) @ odometry_pose(0.0).inverse() @ odometry_pose(2.0)
    assert (end.x, end.y, end.yaw) == pytest.approx((true.x, true.y, true.yaw), abs=1e-9)


def test_many_steps_are_one(trail):
    begin = measured(start(trail), 1, diagonal(1e-4, 1e-4), SHARE)
    begin = begin._replace(lasting=np.array([[0.3, -0.2, 0.1], [1.0, 2.0, -1.0]]))
    one = moved_on(begin, trail.mark_at(BEGIN + 2 * SECOND), SETTINGS)
    many = begin
    for k in range(1, 101):
        many = moved_on(many, trail.mark_at(BEGIN + k * SECOND // 50), SETTINGS)
    assert many[1:4] == pytest.approx(one[1:4], abs=1e-9)
    assert many.covariance[5] == pytest.approx(one.covariance[5])
    assert many.covariance == pytest.approx(one.covariance, rel=0.01, abs=1e-6)
    np.testing.assert_allclose(many.lasting, one.lasting, atol=1e-9)
    np.testing.assert_allclose(many.P[:, 3:], one.P[:, 3:], atol=1e-9)


def test_what_lasts_stays_as_large_as_it_was_while_the_robot_moves(trail):
    end = moved_on(start(trail), trail.mark_at(BEGIN + 2 * SECOND), SETTINGS)
    np.testing.assert_allclose(end.P[3:, 3:], np.eye(6), atol=1e-12)
    np.testing.assert_array_equal(end.P[:3, 3:], np.zeros((3, 6)))


@pytest.mark.parametrize('seed', range(8))
def test_a_measurement_without_lasting_errors_does_what_kalman_says(trail, seed):
    p, r = random_covariance(seed), random_covariance(seed + 50)
    before = start(trail, p)
    d = np.random.default_rng(seed).normal(size=3) * 0.1
    after = mended(before, tuple(d), 0, r, 0.0)
    P, R = as_matrix(p), as_matrix(r)
    information = np.linalg.inv(P) + np.linalg.inv(R)
    np.testing.assert_allclose(as_matrix(after.covariance), np.linalg.inv(information), atol=1e-9)
    x = np.linalg.solve(information, np.linalg.solve(R, d))
    np.testing.assert_allclose(np.array(after[1:4]) - np.array(before[1:4]), x, atol=1e-9)


@pytest.mark.parametrize('seed', range(8))
def test_one_after_the_other_is_all_at_once(trail, seed):
    # Both sources are less accurate than the estimate, so that their biases are estimated.
    rng, p = np.random.default_rng(seed), scaled(random_covariance(seed), 1e-3)
    rough = [random_covariance(seed + 100), random_covariance(seed + 200)]
    said = [(k % 2, 0.1 * rng.normal(size=3), rough[k % 2]) for k in range(6)]
    estimate = start(trail, p)
    for source, z, r in said:
        estimate = mended(estimate, difference_to(estimate, z), source, r, SHARE)
    mean, covariance = by_all_at_once(p, said)
    np.testing.assert_allclose(np.array(estimate[1:4]) - (1.0, 2.0, 0.5), mean[:3], atol=1e-9)
    np.testing.assert_allclose(estimate.lasting.ravel(), mean[3:], atol=1e-9)
    np.testing.assert_allclose(estimate.P, covariance, atol=1e-9)


@pytest.mark.parametrize('seed', range(8))
def test_a_first_measurement_is_one_of_a_robot_that_may_be_anywhere(trail, seed):
    r = random_covariance(seed)
    anywhere = mended(start(trail, scaled(r, 1e9)), (0.0, 0.0, 0.0), 1, r, SHARE)
    first = measured(start(trail, r), 1, r, SHARE)
    np.testing.assert_allclose(first.P, anywhere.P, atol=1e-6)


@pytest.mark.newest_set_only
def test_errors_are_as_large_as_is_said_of_a_source_alone(trail):
    """Many stationary robots, each with its own bias and noise."""
    rng, r = np.random.default_rng(3), scaled(random_covariance(3), 1e-3)
    lever, R = math.sqrt(SHARE) * lasting_root(r), (1.0 - SHARE) * as_matrix(r)
    ends, estimate = [], start(trail)
    for _ in range(400):
        lasting, estimate = lever @ rng.normal(size=3), start(trail, scaled(r, 4.0))
        off = rng.multivariate_normal(np.zeros(3), 4.0 * as_matrix(r))
        for v in rng.multivariate_normal(np.zeros(3), R, size=20):
            z = off + lasting + v
            estimate = mended(estimate, difference_to(estimate, z), 0, r, SHARE)
        ends.append(np.array(estimate[1:4]) - (1.0, 2.0, 0.5) - off)
        np.testing.assert_array_equal(estimate.lasting, np.zeros((2, 3)))
    said = np.linalg.cholesky(as_matrix(estimate.covariance))
    np.testing.assert_allclose(np.cov(np.linalg.solve(said, np.array(ends).T)), np.eye(3), atol=0.25)


def test_what_lasts_is_not_averaged_away(trail):
    noise = diagonal(1e-4, 1e-4)
    after = start(trail, diagonal(1.0, 1.0))
    for _ in range(1000):
        after = mended(after, (0.0, 0.0, 0.0), 0, noise, 0.25)
    for variance in (after.covariance[0], after.covariance[5]):
        assert 0.2499e-4 < variance < 0.26e-4


@pytest.mark.parametrize(('growth', 'kept'), [(0.01, 1.0), (1.0, 1.0), (2.0, 0.5), (100.0, 0.01)])
def test_where_errors_have_grown_something_new_has_come_on_top(trail, growth, kept):
    r, rest = random_covariance(4), 1e-9
    known = measured(start(trail, diagonal(1e-12, 1e-12)), 0, r, SHARE)
    P = known.P.copy()
    P[:3, 3:6] = P[3:6, :3] = 0.0
    P[3:6, 3:6] = rest * np.eye(3)
    known = known._replace(lasting=np.array([[1.0, -2.0, 0.5], [0.0, 0.0, 0.0]]), P=P)
    after = mended(known, (0.0, 0.0, 0.0), 0, scaled(r, growth**2), 1e-6)  # a pose without information
    np.testing.assert_allclose(after.lasting[0], kept * known.lasting[0], rtol=1e-3)
    np.testing.assert_allclose(after.P[3:6, 3:6], (1.0 - kept**2) * np.eye(3), atol=1e-3)


@pytest.mark.parametrize('seed', range(8))
def test_lasting_errors_make_up_the_covariance(seed):
    r = random_covariance(seed)
    L = lasting_root(r)
    np.testing.assert_allclose(L @ L.T, as_matrix(r), atol=1e-12)
    lever = (-0.7, 1.5, 1.0)  # fully correlated with yaw
    r = tuple(1e-4 * lever[i] * lever[j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))
    np.testing.assert_allclose(lasting_root(r)[:, 0], 1e-2 * np.array(lever), atol=1e-12)


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
