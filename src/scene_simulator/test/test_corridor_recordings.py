"""The recorded drives end where they should, in corridors that differ as they should."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scene_simulator.corridor_recordings import RUNS, SECONDS, TAUGHT_POSE, make_corridor_drive
from scene_simulator.errors import SceneError


@pytest.mark.parametrize('name', RUNS)
def test_the_robot_is_stationary_at_its_goal_for_the_last_second(name: str) -> None:
    drive, goal = make_corridor_drive(name), RUNS[name].goal
    assert drive.route.duration < SECONDS - 0.9
    for time in (drive.route.duration, SECONDS):
        pose = drive.pose_at(time)
        assert pose.distance_to(goal) < 1e-9
        assert pose.yaw_to(goal) == pytest.approx(0.0, abs=1e-9)


def test_offsets_reach_half_a_metre_and_fifteen_degrees_to_both_sides() -> None:
    offsets = [TAUGHT_POSE.inverse() @ run.goal for run in RUNS.values()]
    assert (min(o.y for o in offsets), max(o.y for o in offsets)) == pytest.approx((-0.5, 0.5))
    turns = [math.degrees(o.yaw) for o in offsets]
    assert (min(turns), max(turns)) == pytest.approx((-15.0, 15.0))


def test_only_the_moved_sign_is_elsewhere() -> None:
    taught, moved = (
        make_corridor_drive('teach').scene.points_map(),
        make_corridor_drive('moved').scene.points_map(),
    )
    elsewhere = [name for name, point in taught.items() if not np.allclose(point, moved[name])]
    assert elsewhere == ['round_sign']


def test_an_unknown_run_is_refused() -> None:
    with pytest.raises(SceneError, match='choose one of teach, left'):
        make_corridor_drive('sideways')
