"""Outlines are on the primitive."""

import math

import numpy as np
import pytest

from stereo_landmark.core.primitives.corner import Corner
from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.primitives.parallel_lines import ParallelLines
from stereo_landmark.core.primitives.primitive import (
    Tolerances,
    difference,
    primitive_kind,
    primitive_size,
    shape_sizes,
    shape_vectors,
    shift,
)
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral


def test_an_ellipse_is_a_closed_line_with_its_foci():
    ellipse = Ellipse(np.array([40.0, 30.0]), np.array([13.0, 5.0]), 0.4, 1, 1.0, np.eye(5))
    (line,) = ellipse.outline()
    assert line[0] == pytest.approx(line[-1])
    focus = 12.0 * np.array([math.cos(0.4), math.sin(0.4)])
    sums = [np.hypot(*(line - ellipse.centre + sign * focus).T) for sign in (-1, 1)]
    assert sums[0] + sums[1] == pytest.approx(np.full(len(line), 26.0))


def test_parallel_lines_are_two_a_corner_has_two_arms_and_a_quadrilateral_is_closed():
    lines = ParallelLines(6.0, 20.0, 0.0, np.array([30.0, 40.0]), 1, np.eye(3), 1.0).outline()
    assert [line.tolist() for line in lines] == [[[20.0, 37.0], [40.0, 37.0]], [[20.0, 43.0], [40.0, 43.0]]]
    corner = Corner(np.array([5.0, 5.0]), math.pi / 2, math.pi / 4, np.array([3.0, 4.0]), 1, np.eye(2))
    (line,) = corner.outline()
    assert line == pytest.approx(np.array([[8.0, 5.0], [5.0, 5.0], [5.0, 9.0]]))
    corners = np.array([[0.0, 0.0], [9.0, 1.0], [8.0, 7.0], [1.0, 6.0]])
    (line,) = Quadrilateral(corners, 1, 1.0, np.eye(8)).outline()
    assert line == pytest.approx(np.vstack([corners, corners[:1]]))
    vectors = Quadrilateral(corners, 1, 1.0, np.eye(8)).corner_vectors
    assert vectors.sum(axis=0) == pytest.approx([0.0, 0.0])
    assert vectors + corners.mean(axis=0) == pytest.approx(corners)


def test_primitives_of_other_kinds_differ_and_sizes_are_those_of_their_shape_vectors():
    primitives = (
        Ellipse(np.array([40.0, 30.0]), np.array([13.0, 5.0]), 0.4, 1, 1.0, np.eye(5)),
        ParallelLines(6.0, 20.0, 0.0, np.array([30.0, 40.0]), 1, np.eye(3), 1.0),
        Corner(np.array([5.0, 5.0]), math.pi / 2, math.pi / 4, np.array([3.0, 4.0]), 1, np.eye(2)),
        Quadrilateral(np.array([[0.0, 0.0], [9.0, 1.0], [8.0, 7.0], [1.0, 6.0]]), 1, 1.0, np.eye(8)),
    )
    for one in primitives:
        kind = primitive_kind(one)
        assert shape_sizes(kind, shape_vectors(kind, [one]))[0] == pytest.approx(primitive_size(one))
        assert shift(one, np.array([3.0, -2.0])).centre == pytest.approx(np.add(one.centre, [3.0, -2.0]))
        for other in primitives:
            assert (difference(one, other, Tolerances()) == 0.0) == (one is other)
