"""The printed tag and the normalised errors of the benchmark of landmarks."""

import importlib

import numpy as np
import pytest

pytestmark = pytest.mark.newest_set_only


def test_runs_of_white_cells_are_found():
    views = importlib.import_module('_landmark_views')
    assert views.white_runs([True, False, True, True, False]) == [(0, 1), (2, 4)]
    assert views.white_runs([False, False]) == []


def test_the_harness_turns_errors_into_normal_deviates():
    scores = importlib.import_module('_pose_scores')
    rng = np.random.default_rng(2)
    root = np.array([[1e-3, 0.0, 0.0], [2e-3, 1e-3, 0.0], [1e-3, 0.0, 5e-4]])
    errors = (root @ rng.normal(size=3) for _ in range(4000))
    judged = [scores.PoseScore('right', error=error, covariance=root @ root.T) for error in errors]
    np.testing.assert_allclose(np.cov(scores.whitened_errors(judged).T), np.eye(3), atol=0.08)
