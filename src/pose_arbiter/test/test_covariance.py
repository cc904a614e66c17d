"""Covariances of six floats agree with numpy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pose_arbiter.core.covariance import (
    add_covariances,
    as_matrix,
    inverse,
    is_positive_definite,
    mahalanobis_squared,
    rotate_covariance,
    scale_covariance,
)


def random_covariance(seed):
    m = np.random.default_rng(seed).normal(size=(3, 3))
    full = m @ m.T + 0.1 * np.eye(3)
    return tuple(float(full[i, j]) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))


@pytest.mark.parametrize('seed', range(10))
def test_they_agree_with_numpy(seed):
    a, b = random_covariance(seed), random_covariance(seed + 100)
    A, B = as_matrix(a), as_matrix(b)
    rng = np.random.default_rng(seed)
    angle, v = rng.uniform(-3, 3), rng.normal(size=3)
    cos, sin = math.cos(angle), math.sin(angle)
    R = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    for ours, theirs in (
        (add_covariances(a, b), A + B),
        (scale_covariance(a, 3.0), 3.0 * A),
        (rotate_covariance(a, cos, sin), R @ A @ R.T),
        (inverse(a), np.linalg.inv(A)),
    ):
        np.testing.assert_allclose(as_matrix(ours), theirs, atol=1e-9)
    assert mahalanobis_squared(tuple(v), inverse(a)) == pytest.approx(v @ np.linalg.solve(A, v))


@pytest.mark.parametrize('seed', range(20))
def test_positive_definite_is_what_eigenvalues_say(seed):
    m = np.random.default_rng(seed).normal(size=(3, 3))
    full = m + m.T + 2.0 * np.eye(3)
    six = tuple(float(full[i, j]) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))
    assert is_positive_definite(six) == (np.linalg.eigvalsh(full)[0] > 0.0)
