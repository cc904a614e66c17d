"""Invalid sensor poses are rejected with one line."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.voxels.frame_window import SensorView


def changed(row, column, value):
    T = np.eye(4)
    T[row, column] = value
    return T


@pytest.mark.parametrize(
    ('T', 'words'),
    [
        (np.eye(3), 'not a rigid transform'),
        (changed(0, 3, math.nan), 'not a rigid transform'),
        (changed(1, 3, math.inf), 'not a rigid transform'),
        (changed(3, 0, 1.0), 'not a rigid transform'),
        (changed(0, 0, 1.1), 'orthonormal'),
        (changed(2, 2, -1.0), 'right-handed'),
    ],
)
def test_what_is_no_pose_is_refused(T, words):
    with pytest.raises(RewardPlannerError, match=words) as error:
        SensorView(T, 500.0)
    assert '\n' not in str(error.value)


@pytest.mark.parametrize('focal_length', [-1.0, math.nan, math.inf])
def test_what_is_no_focal_length_is_refused(focal_length):
    with pytest.raises(RewardPlannerError, match='focal_length'):
        SensorView(np.eye(4), focal_length)


def test_the_origin_is_where_the_sensor_is():
    assert SensorView(changed(1, 3, 2.5), 0.0).origin.tolist() == [0.0, 2.5, 0.0]
