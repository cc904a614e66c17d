import numpy as np

from stereo_landmark.core.primitives.corner_links import (
    intersect_lines,
    intersect_with_covariance,
    joint_corner_covariance,
)
from stereo_landmark.core.primitives.line_refinement import RefinedLine


def _line(x, y, angle, offset=0.01, turn=0.001):
    direction = np.array([np.cos(angle), np.sin(angle)])
    return RefinedLine(np.array([x, y]), direction, np.array([offset**2, turn**2]), 0.7, 1.0)


def _moved(line, rng):
    offset, turn = np.sqrt(line.variances) * rng.standard_normal(2)
    normal = np.array([-line.direction[1], line.direction[0]])
    angle = np.arctan2(line.direction[1], line.direction[0]) + turn
    return _line(*(line.middle + offset * normal), angle)


LINES = [_line(50, 20, 0.1), _line(80, 45, 1.4, 0.02), _line(50, 70, 3.0), _line(20, 45, -1.5, 0.01, 0.002)]


def test_lines_meet_on_both():
    vertex = intersect_lines(LINES[0], LINES[1])
    for line in LINES[:2]:
        assert abs(np.linalg.det(np.stack([line.direction, vertex - line.middle]))) < 1e-9


def test_covariance_is_that_of_moved_lines():
    rng = np.random.default_rng(0)
    vertices = [intersect_lines(_moved(LINES[0], rng), _moved(LINES[1], rng)) for _ in range(4000)]
    _, covariance = intersect_with_covariance(LINES[0], LINES[1])
    np.testing.assert_allclose(np.cov(np.transpose(vertices)), covariance, rtol=0.1, atol=1e-5)


def test_joint_covariance_is_that_of_moved_lines_and_its_blocks_those_of_single_crossings():
    rng = np.random.default_rng(0)

    def corners(lines):
        return np.array([intersect_lines(lines[k - 1], lines[k]) for k in range(4)])

    covariance = joint_corner_covariance(LINES, corners(LINES))
    samples = [corners([_moved(line, rng) for line in LINES]).ravel() for _ in range(4000)]
    np.testing.assert_allclose(np.cov(np.transpose(samples)), covariance, atol=0.1 * covariance.max())
    _, single = intersect_with_covariance(LINES[1], LINES[2])
    np.testing.assert_allclose(covariance[4:6, 4:6], single, rtol=1e-9)
