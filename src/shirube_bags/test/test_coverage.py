"""Coverage counts the stamps that should have a pose and have one."""

import numpy as np

from shirube_bags.accuracy import compute_coverage

NONE = np.empty((0, 2), dtype=np.int64)


def test_each_stamp_with_a_near_pose_is_covered():
    expected, poses = np.array([0, 100, 200, 300]), np.array([1, 99, 206, 1000])
    coverage = compute_coverage(expected, poses, 5, NONE)
    assert (coverage.expected, coverage.covered, coverage.fraction) == (4, 2, 0.5)
    assert coverage.missing_ns.tolist() == [200, 300]


def test_stamps_in_excluded_intervals_are_left_out_ends_included():
    expected = np.arange(0, 1000, 100)
    coverage = compute_coverage(expected, np.array([0, 100]), 0, np.array([[200, 400], [900, 950]]))
    assert (coverage.expected, coverage.covered, coverage.excluded) == (6, 2, 4)
    assert coverage.missing_ns.tolist() == [500, 600, 700, 800]


def test_overlapping_intervals_exclude_a_stamp_once():
    intervals = np.array([[0, 500], [100, 1000]])
    assert compute_coverage(np.array([300]), np.array([0]), 0, intervals).excluded == 1


def test_nothing_expected_is_wholly_covered():
    assert compute_coverage(np.array([5]), np.array([0]), 0, np.array([[0, 10]])).fraction == 1.0
