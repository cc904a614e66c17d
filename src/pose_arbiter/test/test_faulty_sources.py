"""One faulty source, with each kind of fault: the fused pose stays right."""

from __future__ import annotations

import math
import random

import pytest
from short_drive import BEGIN, ODOMETRY, SECOND, beside, errors, messages, new_arbiter, noisy, tell, true_pose

pytestmark = pytest.mark.newest_set_only

SECONDS, LIE_FROM = 5.0, 2.0
LIES = {
    'offset': lambda s: beside(true_pose(s), 0.2, -0.22),
    'turned': lambda s: beside(true_pose(s), yaw=math.radians(10.0)),
    'frozen': lambda _: true_pose(LIE_FROM),
    'late': lambda s: true_pose(s - 0.5),
    'early': lambda s: true_pose(s + 0.5),
    'jumping': lambda s: beside(true_pose(s), *(random.Random(s).uniform(-1.0, 1.0) for _ in range(3))),
}

CREWS = [(2, 0.0, 0.0), (2, 0.0, 2.0), (1, 2.0, 2.0), (1, 0.0, 2.0)]


@pytest.mark.parametrize('lie', LIES)
@pytest.mark.parametrize(
    ('honest', 'speaks_from', 'lies_from'), [(2, 0.0, 0.0), (2, 0.0, 2.0), (1, 2.0, 2.0), (1, 0.0, 2.0)]
)
def test_at_most_three_poses_are_wrong(lie, honest, speaks_from, lies_from):
    def liar(seconds):
        if seconds < speaks_from:
            return None
        return LIES[lie](seconds) if seconds >= lies_from else true_pose(seconds)

    arbiter, wrong, told = new_arbiter(honest + 1), 0, 0
    sources = [noisy(k) for k in range(honest)]
    sources.insert(1, liar)
    for message in messages(SECONDS, sources):
        tell(arbiter, [message])
        at = (message[0] - BEGIN) / SECOND
        if message[1] == ODOMETRY and at >= lies_from and arbiter.estimate_at(message[0]) is not None:
            off, turned = errors(arbiter, at)
            told += 1
            wrong += off > 0.05 or turned > math.radians(3.0)
    assert told > 140
    assert wrong <= 3
