"""Pairs of cameras from their projection matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from l_rig import projection

from reward_planner.core.depth.stereo_pair import pair_from_projections
from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.geometry import PinholeCamera


@pytest.mark.parametrize(('x', 'y'), [(0.1, 0.0), (-0.12, 0.0), (0.0, 0.08), (0.0, -0.1)])
def test_the_baseline_is_the_position_of_the_other_camera(x, y):
    pair = pair_from_projections(projection(), projection(x=x, y=y))
    assert pair.axis == (0 if x else 1)
    assert pair.baseline == pytest.approx(x + y)
    assert pair.focal_baseline == pytest.approx(262.5 * abs(x + y))


def test_a_projected_point_moves_by_the_disparity():
    point = np.array([0.3, -0.2, 2.0, 1.0])
    for x, y in ((0.1, 0.0), (0.0, -0.1)):
        pair = pair_from_projections(projection(), projection(x=x, y=y))
        left, other = (P @ point / (P @ point)[2] for P in (projection(), projection(x=x, y=y)))
        moved = left[pair.axis] - other[pair.axis]
        assert moved == pytest.approx(pair.sign * pair.focal_baseline / 2.0 + pair.offset)


def changed(row, column, value):
    P = projection(x=0.1)
    P[row, column] = value
    return P


@pytest.mark.parametrize(
    ('other', 'words'),
    [
        (projection(), 'no baseline'),
        (changed(1, 3, -20.0), 'neither a horizontal nor a vertical pair'),
        (changed(1, 2, 125.0), 'principal points'),
        (changed(0, 0, 270.0), 'focal lengths differ'),
        (changed(0, 3, math.nan), 'not a projection matrix'),
        (np.eye(3), 'not a projection matrix'),
        (np.zeros((3, 4)), 'not a projection matrix'),
    ],
)
def test_cameras_that_are_no_rectified_pair_are_refused(other, words):
    with pytest.raises(RewardPlannerError, match=words) as error:
        pair_from_projections(projection(), other)
    assert '\n' not in str(error.value)


def test_a_shifted_principal_point_is_an_offset():
    shifted = projection(PinholeCamera(320, 240, 262.5, 262.5, 163.5, 119.5), x=0.1)
    assert pair_from_projections(projection(), shifted).offset == pytest.approx(-4.0)
