"""All nodes answer the same for the same odometry: between two messages, and a little beyond the last one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floor_localizer.core.settings import TrackerSettings
from floor_localizer.core.tracker import PosePredictor
from floor_localizer.survey_files.survey_source import SurveyOdometry
from pose_arbiter.core.arbiter import OPERATOR, Arbiter
from pose_arbiter.core.kalman_filter import diagonal
from pose_arbiter.core.settings import ArbiterSettings
from reward_planner.core.mapping.pose_buffer import PoseBuffer
from reward_planner.core.settings import MappingSettings
from shirube_core.geometry import SE2
from vlc_beacon.core.receiver.beacon_receiver import LampOdometry

pytestmark = pytest.mark.quick

SECOND = 1_000_000_000
STEP = SECOND // 10
TWISTS = st.tuples(st.floats(-0.7, 0.7), st.floats(-0.2, 0.2), st.floats(-2.0, 2.0))


def motions(messages: list[tuple[int, SE2]], start: int, end: int) -> dict[str, SE2]:
    """Return the motion between two stamps [ns] by the buffer of each node that answers."""
    predictor, lamps, planner = (PosePredictor(TrackerSettings()), LampOdometry(), PoseBuffer(MappingSettings()))
    arbiter = Arbiter([], ArbiterSettings())
    for stamp, pose in messages:
        predictor.add_odometry(1e-9 * stamp, pose)
        lamps.add(1e-9 * stamp, pose)
        planner.add(1e-9 * stamp, pose)
        assert arbiter.add_odometry(stamp, pose, stamp) is None
    rows = np.array([(pose.x, pose.y, pose.yaw) for _, pose in messages])
    survey = SurveyOdometry(np.array([stamp for stamp, _ in messages]), rows, '/odom')
    arbiter.add_pose(OPERATOR, start, SE2(0.0, 0.0, 0.0), diagonal(1e-6, 1e-6), start)
    estimate = arbiter.estimate_at(end)
    ends = {
        'survey': (survey.pose_at(start, 'a'), survey.pose_at(end, 'b')),
        'lamps': (lamps.pose_at(1e-9 * start), lamps.pose_at(1e-9 * end)),
        'planner': (planner.pose_at(1e-9 * start), planner.pose_at(1e-9 * end)),
    }
    found = {name: a.inverse() @ b for name, (a, b) in ends.items() if isinstance(a, SE2) and isinstance(b, SE2)}
    return found | {
        'tracker': predictor.relative_motion(1e-9 * start, 1e-9 * end),
        'arbiter': SE2(estimate.x, estimate.y, estimate.yaw),
    }


@given(st.lists(TWISTS, min_size=3, max_size=8), st.integers(-STEP, STEP))
def test_all_nodes_give_the_same_motion(twists: list[tuple[float, ...]], ahead: int) -> None:
    poses = [SE2(1.0, 2.0, 3.0)]
    for twist in twists:
        poses.append(poses[-1] @ SE2.exp(*(0.1 * v for v in twist)))
    messages = [(SECOND + k * STEP, pose) for k, pose in enumerate(poses)]
    found = motions(messages, SECOND + STEP // 3, messages[-1][0] + ahead)
    assert len(found) == (5 if ahead <= 0 else 4)  # the planner waits for the next pose
    for motion in found.values():
        assert motion.distance_to(found['arbiter']) < 1e-9
        assert abs(motion.yaw_to(found['arbiter'])) < 1e-9
