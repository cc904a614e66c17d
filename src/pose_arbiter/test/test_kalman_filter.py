"""Filter steps against second implementations: information form, all measurements in one batch, numpy."""

import math

import numpy as np
import pytest
from short_drive import BEGIN, SECOND, odometry_pose

from pose_arbiter.core.kalman_filter import (
    bias_sqrt,
    compute_innovation,
    diagonal,
    initialize,
    initialize_from_source,
    is_positive_definite,
    predict,
    update,
)
from pose_arbiter.core.settings import ArbiterSettings
from shirube_core.geometry import SE2
from shirube_core.motion import OdometryBuffer

SETTINGS = ArbiterSettings()
BIAS_FRACTION = 0.4


def random_covariance(seed):
    m = np.random.default_rng(seed).normal(size=(3, 3))
    return m @ m.T + 0.1 * np.eye(3)


@pytest.fixture
def buffer():
    made = OdometryBuffer()
    for k in range(101):
        made.add(BEGIN + k * SECOND // 50, odometry_pose(k / 50))
    return made


def start(buffer, noise=None, sources=2):
    noise = diagonal(1e-4, 1e-4) if noise is None else noise
    return initialize(buffer.lookup(BEGIN), SE2(1.0, 2.0, 0.5), noise, sources)


def innovation_to(estimate, z):
    return compute_innovation(estimate, SE2(1.0 + z[0], 2.0 + z[1], 0.5 + z[2]))


def solve_batch(p, said):
    """Return mean and covariance of pose and biases of two sources after measurements (source, z, R)."""
    information, vector = np.eye(9), np.zeros(9)
    information[:3, :3] = np.linalg.inv(p)
    for source, z, r in said:
        H = np.zeros((3, 9))
        H[:, :3] = np.eye(3)
        H[:, 3 + 3 * source : 6 + 3 * source] = math.sqrt(BIAS_FRACTION) * bias_sqrt(r)
        weight = np.linalg.inv((1.0 - BIAS_FRACTION) * r)
        information += H.T @ weight @ H
        vector += H.T @ weight @ z
    return np.linalg.solve(information, vector), np.linalg.inv(information)


def test_many_predictions_equal_one(buffer):
    begin = initialize_from_source(start(buffer), 1, diagonal(1e-4, 1e-4), BIAS_FRACTION)
    begin = begin._replace(bias=np.array([[0.3, -0.2, 0.1], [1.0, 2.0, -1.0]]))
    one = predict(begin, buffer.lookup(BEGIN + 2 * SECOND), SETTINGS)
    many = begin
    for k in range(1, 101):
        many = predict(many, buffer.lookup(BEGIN + k * SECOND // 50), SETTINGS)
    assert many[1:4] == pytest.approx(one[1:4], abs=1e-9)
    assert many.covariance[2, 2] == pytest.approx(one.covariance[2, 2])
    assert many.covariance == pytest.approx(one.covariance, rel=0.01, abs=1e-6)
    np.testing.assert_allclose(many.bias, one.bias, atol=1e-9)
    np.testing.assert_allclose(many.P[:, 3:], one.P[:, 3:], atol=1e-9)


def test_the_bias_covariance_is_stationary(buffer):
    """The pose goes as odometry goes meanwhile."""
    end = predict(start(buffer), buffer.lookup(BEGIN + 2 * SECOND), SETTINGS)
    true = SE2(1.0, 2.0, 0.5) @ odometry_pose(0.0).inverse() @ odometry_pose(2.0)
    assert (end.x, end.y, end.yaw) == pytest.approx((true.x, true.y, true.yaw), abs=1e-9)
    np.testing.assert_allclose(end.P[3:, 3:], np.eye(6), atol=1e-12)
    np.testing.assert_array_equal(end.P[:3, 3:], np.zeros((3, 6)))
    turned = compute_innovation(end._replace(yaw=3.1), SE2(1.0, 2.0, -3.1))
    assert turned[2] == pytest.approx(math.tau - 6.2)  # the short way around


@pytest.mark.parametrize('seed', range(8))
def test_a_measurement_without_bias_is_a_kalman_update(buffer, seed):
    p, r = random_covariance(seed), random_covariance(seed + 50)
    before = start(buffer, p)
    d = np.random.default_rng(seed).normal(size=3) * 0.1
    after = update(before, tuple(d), 0, r, 0.0)
    information = np.linalg.inv(p) + np.linalg.inv(r)
    np.testing.assert_allclose(after.covariance, np.linalg.inv(information), atol=1e-9)
    x = np.linalg.solve(information, np.linalg.solve(r, d))
    np.testing.assert_allclose(np.array(after[1:4]) - np.array(before[1:4]), x, atol=1e-9)


@pytest.mark.parametrize('seed', range(8))
def test_sequential_updates_equal_the_batch_solution(buffer, seed):
    # Both sources are less accurate than the estimate, so that their biases are estimated.
    rng, p = np.random.default_rng(seed), 1e-3 * random_covariance(seed)
    rough = [random_covariance(seed + 100), random_covariance(seed + 200)]
    said = [(k % 2, 0.1 * rng.normal(size=3), rough[k % 2]) for k in range(6)]
    estimate = start(buffer, p)
    for source, z, r in said:
        estimate = update(estimate, innovation_to(estimate, z), source, r, BIAS_FRACTION)
    mean, covariance = solve_batch(p, said)
    np.testing.assert_allclose(np.array(estimate[1:4]) - (1.0, 2.0, 0.5), mean[:3], atol=1e-9)
    np.testing.assert_allclose(estimate.bias.ravel(), mean[3:], atol=1e-9)
    np.testing.assert_allclose(estimate.P, covariance, atol=1e-9)


@pytest.mark.parametrize('seed', range(8))
def test_a_first_measurement_is_one_of_a_robot_that_may_be_anywhere(buffer, seed):
    r = random_covariance(seed)
    anywhere = update(start(buffer, 1e9 * r), (0.0, 0.0, 0.0), 1, r, BIAS_FRACTION)
    first = initialize_from_source(start(buffer, r), 1, r, BIAS_FRACTION)
    np.testing.assert_allclose(first.P, anywhere.P, atol=1e-6)


@pytest.mark.newest_set_only
def test_the_covariance_of_a_single_source_is_consistent(buffer):
    """Many stationary robots, each with its own bias and noise."""
    rng, r = np.random.default_rng(3), 1e-3 * random_covariance(3)
    bias_gain, R = math.sqrt(BIAS_FRACTION) * bias_sqrt(r), (1.0 - BIAS_FRACTION) * r
    ends, estimate = [], start(buffer)
    for _ in range(400):
        bias, estimate = bias_gain @ rng.normal(size=3), start(buffer, 4.0 * r)
        off = rng.multivariate_normal(np.zeros(3), 4.0 * r)
        for v in rng.multivariate_normal(np.zeros(3), R, size=20):
            z = off + bias + v
            estimate = update(estimate, innovation_to(estimate, z), 0, r, BIAS_FRACTION)
        ends.append(np.array(estimate[1:4]) - (1.0, 2.0, 0.5) - off)
        np.testing.assert_array_equal(estimate.bias, np.zeros((2, 3)))
    said = np.linalg.cholesky(estimate.covariance)
    np.testing.assert_allclose(np.cov(np.linalg.solve(said, np.array(ends).T)), np.eye(3), atol=0.25)


def test_bias_is_not_averaged_away(buffer):
    noise = diagonal(1e-4, 1e-4)
    after = start(buffer, diagonal(1.0, 1.0))
    for _ in range(1000):
        after = update(after, (0.0, 0.0, 0.0), 0, noise, 0.25)
    for variance in after.covariance.diagonal()[::2]:
        assert 0.2499e-4 < variance < 0.26e-4


@pytest.mark.parametrize(('ratio', 'decay'), [(0.01, 1.0), (1.0, 1.0), (2.0, 0.5), (100.0, 0.01)])
def test_a_larger_sigma_adds_an_independent_bias(buffer, ratio, decay):
    r, rest = random_covariance(4), 1e-9
    known = initialize_from_source(start(buffer, diagonal(1e-12, 1e-12)), 0, r, BIAS_FRACTION)
    P = known.P.copy()
    P[:3, 3:6] = P[3:6, :3] = 0.0
    P[3:6, 3:6] = rest * np.eye(3)
    known = known._replace(bias=np.array([[1.0, -2.0, 0.5], [0.0, 0.0, 0.0]]), P=P)
    # A pose without information.
    after = update(known, (0.0, 0.0, 0.0), 0, ratio**2 * r, 1e-6)
    np.testing.assert_allclose(after.bias[0], decay * known.bias[0], rtol=1e-3)
    np.testing.assert_allclose(after.P[3:6, 3:6], (1.0 - decay**2) * np.eye(3), atol=1e-3)


@pytest.mark.parametrize('seed', range(8))
def test_bias_sqrt_is_a_square_root_of_the_covariance(seed):
    r = random_covariance(seed)
    L = bias_sqrt(r)
    np.testing.assert_allclose(L @ L.T, r, atol=1e-12)
    bias_gain = (-0.7, 1.5, 1.0)  # fully correlated with yaw
    r = 1e-4 * np.outer(bias_gain, bias_gain)
    np.testing.assert_allclose(bias_sqrt(r)[:, 0], 1e-2 * np.array(bias_gain), atol=1e-12)


@pytest.mark.parametrize('seed', range(20))
def test_positive_definite_is_what_eigenvalues_say(seed):
    m = np.random.default_rng(seed).normal(size=(3, 3))
    full = m + m.T + 2.0 * np.eye(3)
    assert is_positive_definite(full) == (np.linalg.eigvalsh(full)[0] > 0.0)
