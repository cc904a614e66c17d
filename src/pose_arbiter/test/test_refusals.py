"""Invalid messages leave the state unchanged."""

from __future__ import annotations

import math
import random

import pytest
from short_drive import BEGIN, SECOND, messages, new_arbiter, noisy, numbers, tell, true_pose

from pose_arbiter.core.arbiter import PERSON
from pose_arbiter.core.covariance import diagonal
from pose_arbiter.core.verdict import Refusal
from shirube_geometry import PlanarPose

NAN, INF = math.nan, math.inf
SAID = messages(1.0, [noisy(1), noisy(2)])
NOW = SAID[-1][0]
GOOD = true_pose(0.9)
FINE = diagonal(1e-4, 1e-4)

BAD = [
    (NOW, PlanarPose(NAN, 0.0, 0.0), FINE, Refusal.NOT_FINITE),
    (NOW, PlanarPose(0.0, INF, 0.0), FINE, Refusal.NOT_FINITE),
    (NOW, PlanarPose(0.0, 0.0, -INF), FINE, Refusal.NOT_FINITE),
    (NOW, PlanarPose(1e300, 0.0, 0.0), FINE, Refusal.FAR),
    (NOW, GOOD, diagonal(-1.0, 1.0), Refusal.BAD_COVARIANCE),
    (NOW, GOOD, diagonal(0.0, 0.0), Refusal.BAD_COVARIANCE),
    (NOW, GOOD, diagonal(1e-30, 1e-30), Refusal.BAD_COVARIANCE),
    (NOW, GOOD, diagonal(1e9, 1.0), Refusal.BAD_COVARIANCE),
    (NOW, GOOD, diagonal(NAN, 1.0), Refusal.BAD_COVARIANCE),
    (NOW, GOOD, (1.0, 2.0, 0.0, 1.0, 0.0, 1.0), Refusal.BAD_COVARIANCE),
    (0, GOOD, FINE, Refusal.NO_STAMP),
    (-5, GOOD, FINE, Refusal.NO_STAMP),
    (NOW + SECOND, GOOD, FINE, Refusal.FUTURE),
    (2**62, GOOD, FINE, Refusal.FUTURE),
    (NOW - 3 * SECOND, GOOD, FINE, Refusal.TOO_OLD),
    (5, GOOD, FINE, Refusal.TOO_OLD),
    (next(m[0] for m in SAID if m[1] == 0), GOOD, FINE, Refusal.DUPLICATE),
]


@pytest.fixture
def arbiter():
    made = new_arbiter(2)
    tell(made, SAID)
    return made


@pytest.mark.parametrize(('stamp', 'pose', 'noise', 'reason'), BAD)
def test_a_bad_pose_is_refused_and_changes_nothing(arbiter, stamp, pose, noise, reason):
    before, counts = numbers(arbiter.estimate_at(NOW)), arbiter.counts()
    assert arbiter.add_pose(0, stamp, pose, noise, NOW) is reason
    assert (numbers(arbiter.estimate_at(NOW)), arbiter.counts()) == (before, counts)


@pytest.mark.parametrize(
    ('stamp', 'pose', 'reason'),
    [
        (NOW, PlanarPose(NAN, 0.0, 0.0), Refusal.NOT_FINITE),
        (NOW, PlanarPose(0.0, 1e12, 0.0), Refusal.FAR),
        (0, GOOD, Refusal.NO_STAMP),
        (NOW + SECOND, GOOD, Refusal.FUTURE),
        (NOW - 3 * SECOND, GOOD, Refusal.TOO_OLD),
        (NOW, GOOD, Refusal.DUPLICATE),
    ],
)
def test_bad_odometry_is_refused_and_changes_nothing(arbiter, stamp, pose, reason):
    before = numbers(arbiter.estimate_at(NOW))
    assert arbiter.add_odometry(stamp, pose, NOW) is reason
    assert numbers(arbiter.estimate_at(NOW)) == before


def test_a_bad_word_of_a_person_is_refused(arbiter):
    before = numbers(arbiter.estimate_at(NOW))
    assert arbiter.add_pose(PERSON, NOW, PlanarPose(NAN, 0.0, 0.0), FINE, NOW) is Refusal.NOT_FINITE
    assert numbers(arbiter.estimate_at(NOW)) == before


def test_after_a_stamp_of_the_future_the_source_is_still_heard(arbiter):
    arbiter.add_pose(0, NOW + 1000 * SECOND, GOOD, FINE, NOW)
    used = arbiter.belief_at(NOW).records[0].standing
    assert arbiter.add_pose(0, NOW, true_pose((NOW - BEGIN) / SECOND), FINE, NOW) is None
    assert arbiter.belief_at(NOW).records[0].standing == used + 1


def test_a_thousand_bad_messages_are_as_if_they_had_never_come():
    rng, disturbed, plain = random.Random(3), new_arbiter(2), new_arbiter(2)
    for message in SAID:
        now = message[0]
        for _ in range(8):
            stamp, pose, noise, _ = rng.choice(BAD[:14])
            stamp = stamp if stamp != NOW else now
            assert disturbed.add_pose(rng.randrange(2), stamp, pose, noise, now) is not None
        tell(disturbed, [message])
        tell(plain, [message])
    assert numbers(disturbed.estimate_at(NOW)) == numbers(plain.estimate_at(NOW))
    assert disturbed.counts() == plain.counts()
