"""Invalid messages leave the state unchanged."""

import math
import random

import numpy as np
import pytest
from short_drive import BEGIN, ODOMETRY, SECOND, add_messages, messages, new_arbiter, noisy, numbers, true_pose

from pose_arbiter.core.arbiter import OPERATOR
from pose_arbiter.core.kalman_filter import diagonal
from pose_arbiter.core.source_state import RejectReason
from shirube_core.geometry import SE2

NAN, INF = math.nan, math.inf
SAID = messages(1.0, [noisy(1), noisy(2)])
NOW = SAID[-1][0]
GOOD = true_pose(0.9)
FINE = diagonal(1e-4, 1e-4)

NOT_FINITE = [SE2(NAN, 0.0, 0.0), SE2(0.0, INF, 0.0), SE2(0.0, 0.0, -INF)]
VARIANCES = [(-1.0, 1.0), (0.0, 0.0), (1e-30, 1e-30), (1e9, 1.0), (NAN, 1.0), (INF, 1.0)]
BAD = [
    *[(NOW, pose, FINE, RejectReason.NOT_FINITE) for pose in NOT_FINITE],
    (NOW, SE2(1e300, 0.0, 0.0), FINE, RejectReason.TOO_FAR),
    *[(NOW, GOOD, diagonal(*pair), RejectReason.BAD_COVARIANCE) for pair in VARIANCES],
    (NOW, GOOD, np.array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), RejectReason.BAD_COVARIANCE),
    (0, GOOD, FINE, RejectReason.NO_STAMP),
    (-5, GOOD, FINE, RejectReason.NO_STAMP),
    (NOW + SECOND, GOOD, FINE, RejectReason.FUTURE),
    (2**62, GOOD, FINE, RejectReason.FUTURE),
    (NOW - 3 * SECOND, GOOD, FINE, RejectReason.TOO_OLD),
    (5, GOOD, FINE, RejectReason.TOO_OLD),
]


@pytest.fixture
def arbiter():
    made = new_arbiter(2)
    add_messages(made, SAID)
    return made


@pytest.mark.parametrize('source', [0, OPERATOR, ODOMETRY])
@pytest.mark.parametrize(('stamp', 'pose', 'noise', 'reason'), [*BAD, (NOW, GOOD, FINE, RejectReason.DUPLICATE)])
def test_a_bad_message_is_refused_and_changes_nothing(arbiter, source, stamp, pose, noise, reason):
    before, counts = numbers(arbiter.estimate_at(NOW)), arbiter.counts()
    if source == ODOMETRY:
        if reason is RejectReason.BAD_COVARIANCE:
            return
        assert arbiter.add_odometry(stamp, pose, NOW) is reason
    elif reason is not RejectReason.DUPLICATE:
        assert arbiter.add_pose(source, stamp, pose, noise, NOW) is reason
    assert (numbers(arbiter.estimate_at(NOW)), arbiter.counts()) == (before, counts)


def test_after_a_duplicate_and_a_stamp_in_the_future_the_source_is_still_accepted(arbiter):
    stamp = next(m[0] for m in SAID if m[1] == 0)
    assert arbiter.add_pose(0, stamp, GOOD, FINE, NOW) is RejectReason.DUPLICATE
    arbiter.add_pose(0, NOW + 1000 * SECOND, GOOD, FINE, NOW)
    used = arbiter.state_at(NOW).source_states[0].accepted_count
    assert arbiter.add_pose(0, NOW, true_pose((NOW - BEGIN) / SECOND), FINE, NOW) is None
    assert arbiter.state_at(NOW).source_states[0].accepted_count == used + 1


def test_a_thousand_bad_messages_are_as_if_they_had_never_come():
    rng, disturbed, plain = random.Random(3), new_arbiter(2), new_arbiter(2)
    for message in SAID:
        now = message[0]
        for _ in range(8):
            stamp, pose, noise, _ = rng.choice(BAD[:15])
            stamp = stamp if stamp != NOW else now
            assert disturbed.add_pose(rng.randrange(2), stamp, pose, noise, now) is not None
        add_messages(disturbed, [message])
        add_messages(plain, [message])
    assert numbers(disturbed.estimate_at(NOW)) == numbers(plain.estimate_at(NOW))
    assert disturbed.counts() == plain.counts()
