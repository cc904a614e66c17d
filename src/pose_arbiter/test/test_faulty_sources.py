"""One faulty source, with each kind of fault: the fused pose stays right."""

import math
import random

import pytest
from short_drive import (
    BEGIN,
    ODOMETRY,
    SECOND,
    add_messages,
    errors,
    messages,
    new_arbiter,
    noisy,
    shift_pose,
    true_pose,
)

pytestmark = pytest.mark.newest_set_only

SECONDS, FAULT_FROM = 5.0, 2.0
FAULTS = {
    'offset': lambda s: shift_pose(true_pose(s), 0.2, -0.22),
    'turned': lambda s: shift_pose(true_pose(s), yaw=math.radians(10.0)),
    'frozen': lambda _: true_pose(FAULT_FROM),
    'late': lambda s: true_pose(s - 0.5),
    'early': lambda s: true_pose(s + 0.5),
    'jumping': lambda s: shift_pose(true_pose(s), *(random.Random(s).uniform(-1.0, 1.0) for _ in range(3))),
}
CREWS = [(2, 0.0, 0.0), (2, 0.0, 2.0), (1, 2.0, 2.0), (1, 0.0, 2.0)]


@pytest.mark.parametrize('fault', FAULTS)
@pytest.mark.parametrize(('correct', 'starts', 'fault_from'), CREWS)
def test_at_most_three_poses_are_wrong(fault, correct, starts, fault_from):
    def faulty_source(seconds):
        if seconds < starts:
            return None
        return FAULTS[fault](seconds) if seconds >= fault_from else true_pose(seconds)

    arbiter, wrong, count = new_arbiter(correct + 1), 0, 0
    sources = [noisy(k) for k in range(correct)]
    sources.insert(1, faulty_source)
    for message in messages(SECONDS, sources):
        add_messages(arbiter, [message])
        at = (message[0] - BEGIN) / SECOND
        if message[1] == ODOMETRY and at >= fault_from and arbiter.estimate_at(message[0]) is not None:
            off, turned = errors(arbiter, at)
            count += 1
            wrong += off > 0.05 or turned > math.radians(3.0)
    assert count > 140
    assert wrong <= 3
