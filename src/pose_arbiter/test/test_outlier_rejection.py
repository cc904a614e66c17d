"""Outlier rejection: which sources are accepted, and when the estimate is reset."""

import math
import random

import pytest
from short_drive import (
    BEGIN,
    ODOMETRY,
    SECOND,
    SIGMA,
    add_messages,
    errors,
    messages,
    new_arbiter,
    noisy,
    odometry_pose,
    shift_pose,
    true_pose,
)

from pose_arbiter.core.arbiter import OPERATOR, LocalizationStatus, localization_status
from pose_arbiter.core.kalman_filter import diagonal
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from pose_arbiter.core.source_state import MeasurementStatus
from shirube_core.geometry import SE2


def until(source, end):
    return lambda seconds: source(seconds) if seconds < end else None


def displaced_pose(seconds):
    return SE2(1.0, -2.0, 0.5) @ true_pose(seconds)


def wrong_at_first(seconds):
    return true_pose(seconds) if seconds < 1.0 or seconds > 4.0 else displaced_pose(seconds)


def run(seconds, sources, **settings):
    arbiter = new_arbiter(len(sources), **settings)
    add_messages(arbiter, messages(seconds, sources))
    return arbiter


def status_at(arbiter, seconds, count, **limits):
    stamp = BEGIN + round(seconds * SECOND)
    sources = (SourceSettings(),) * count
    return localization_status(arbiter.state_at(stamp), arbiter.estimate_at(stamp), sources, ArbiterSettings(**limits))


def test_with_several_sources_the_first_one_waits_in_vain_for_a_second_opinion_only_for_a_while():
    assert max(errors(run(0.1, [noisy(1)]), 0.1)) < 0.02  # a lone one does not wait
    arbiter = run(0.5, [noisy(1), lambda _: None])
    assert arbiter.estimate_at(BEGIN + SECOND // 2) is None
    assert status_at(arbiter, 0.5, 2) is LocalizationStatus.WAITING
    assert max(errors(run(1.5, [noisy(1), lambda _: None]), 1.5)) < 0.02


def test_at_the_start_two_outvote_one():
    for place in range(3):
        sources = [noisy(1), noisy(2)]
        sources.insert(place, noisy(3, pose_at=displaced_pose))
        assert max(errors(run(0.2, sources), 0.2)) < 0.02


def test_at_the_start_the_higher_priority_decides_between_two():
    for priorities in ((1, 0), (0, 1)):
        sources = [SourceSettings(sigma_xy=0.005, sigma_yaw=0.005, priority=p) for p in priorities]
        arbiter = new_arbiter(2, sources)
        add_messages(arbiter, messages(1.5, [noisy(1), noisy(2, pose_at=displaced_pose)]))
        assert (errors(arbiter, 1.5)[0] < 0.02) == (priorities[0] == 1)


def test_one_wild_pose_is_refused():
    wild = BEGIN + SECOND + 1
    arbiter = new_arbiter(1)
    add_messages(arbiter, [*messages(1.0, [noisy(1)]), (wild, 0, displaced_pose(1.0))])
    assert max(errors(arbiter, 1.01)) < 0.03
    assert arbiter.counts()[0, MeasurementStatus.ODOMETRY_INCONSISTENT] == 1


def kidnapped(seconds):
    return true_pose(seconds) if seconds < 1.0 else displaced_pose(seconds)


def test_a_kidnapped_robot_is_relocalized_after_the_timeout():
    arbiter = run(4.0, [kidnapped])
    estimate = arbiter.estimate_at(BEGIN + 4 * SECOND)
    assert (estimate.x, estimate.y) == pytest.approx((displaced_pose(4.0).x, displaced_pose(4.0).y), abs=0.03)
    assert max(errors(run(1.8, [kidnapped]), 1.8)) < 0.05


def test_a_new_source_changes_nothing_while_another_supports_the_pose():
    arbiter = run(6.0, [noisy(1), lambda s: displaced_pose(s) if s >= 2.0 else None])
    assert max(errors(arbiter, 6.0)) < 0.02
    assert arbiter.counts()[1, MeasurementStatus.OUTSIDE_GATE] > 50
    assert arbiter.counts()[1, MeasurementStatus.RESET] == 0


@pytest.mark.parametrize('is_other_there', [True, False])
def test_a_rejected_source_stays_on_probation_while_another_supports_the_pose(is_other_there):
    other = noisy(1) if is_other_there else until(noisy(1), 3.9)
    arbiter = run(8.0, [other, wrong_at_first])
    assert arbiter.counts()[1, MeasurementStatus.OUTSIDE_GATE] > 20
    probation = arbiter.counts()[1, MeasurementStatus.PROBATION]
    assert 19 <= probation <= 21 if is_other_there else probation < 15
    assert arbiter.state_at(BEGIN + 8 * SECOND).source_states[1].status is MeasurementStatus.USED
    assert max(errors(arbiter, 8.0)) < 0.02


def test_two_sources_that_agree_outvote_one_that_drifted():
    def drifting(seconds):
        return shift_pose(true_pose(seconds), 0.03 * max(seconds - 1.0, 0.0))

    arbiter = run(6.0, [noisy(1), drifting, noisy(2)])
    assert max(errors(arbiter, 6.0)) < 0.03
    assert arbiter.state_at(BEGIN + 6 * SECOND).source_states[1].status is not MeasurementStatus.USED


def test_a_frozen_source_is_rejected_by_odometry():
    arbiter = run(4.0, [noisy(1), lambda s: true_pose(min(s, 1.0))])
    assert max(errors(arbiter, 4.0)) < 0.02
    assert arbiter.counts()[1, MeasurementStatus.ODOMETRY_INCONSISTENT] > 30


def test_two_sources_are_accepted_against_wheels_that_slip():
    said = [m for m in messages(4.0, [noisy(1), noisy(2)]) if m[1] != ODOMETRY]
    said += [(BEGIN + k * SECOND // 50, ODOMETRY, odometry_pose(min(k / 50, 1.0))) for k in range(201)]
    arbiter = new_arbiter(2)
    add_messages(arbiter, sorted(said, key=lambda m: m[0]))
    assert max(errors(arbiter, 4.0)) < 0.05


def test_when_one_falls_silent_the_other_goes_on_without_a_jump():
    arbiter = run(4.0, [until(noisy(1), 2.0), noisy(2)])
    for k in range(15, 40):
        assert max(errors(arbiter, k / 10)) < 0.02 if k >= 20 else True
    assert status_at(arbiter, 4.0, 2) is LocalizationStatus.TRACKING


def test_without_sources_odometry_carries_on_and_then_the_pose_is_lost():
    arbiter = run(30.0, [until(noisy(1), 2.0)])
    for limits in ({'lost_sigma_yaw': 0.1}, {'lost_sigma_xy': 0.1}):
        assert status_at(arbiter, 30.0, 1, **limits) is LocalizationStatus.LOST
    assert status_at(arbiter, 30.0, 1) is LocalizationStatus.ODOMETRY_ONLY
    short = run(5.0, [until(noisy(1), 2.0)])
    assert status_at(short, 5.0, 1) is LocalizationStatus.ODOMETRY_ONLY
    assert max(errors(short, 5.0)) < 0.15


def test_without_odometry_the_pose_is_lost_soon_and_found_again():
    source = lambda s: None if 1.0 < s < 4.0 else true_pose(s)  # noqa: E731
    said = [m for m in messages(5.0, [source]) if m[1] != ODOMETRY]
    arbiter = new_arbiter(1)
    add_messages(arbiter, [m for m in said if m[0] < BEGIN + 2 * SECOND])
    assert status_at(arbiter, 3.5, 1) is LocalizationStatus.LOST
    add_messages(arbiter, [m for m in said if m[0] > BEGIN + 2 * SECOND])
    assert status_at(arbiter, 5.0, 1) is LocalizationStatus.TRACKING
    assert errors(arbiter, 5.0)[0] < 0.05


def test_an_initial_pose_holds_until_a_source_disagrees():
    arbiter = run(1.0, [noisy(1)])
    initial_pose, now = displaced_pose(1.0), BEGIN + SECOND
    assert arbiter.add_pose(OPERATOR, now, initial_pose, diagonal(0.01, 0.01), now) is None
    assert arbiter.estimate_at(now).x == pytest.approx(initial_pose.x)
    add_messages(arbiter, messages(1.0, [noisy(1)], begin=1.001))
    assert max(errors(arbiter, 2.0)) < 0.03


def test_a_pose_that_the_estimate_is_set_to_counts_half_as_sure_as_it_claims():
    arbiter = run(0.05, [true_pose])
    estimate = arbiter.estimate_at(BEGIN + 3_000_000)
    assert arbiter.counts() == {(0, MeasurementStatus.RESET): 1}
    assert estimate.covariance[0, 0] == pytest.approx(SIGMA**2)  # the only source is not inflated
    jumped = run(4.0, [kidnapped])
    after = [jumped.estimate_at(BEGIN + SECOND + k * SECOND // 20 + 3_000_000) for k in range(80)]
    reset = next(estimate for estimate in after if estimate.x > 1.0)
    assert reset.covariance[0, 0] == pytest.approx(4.0 * SIGMA**2, rel=0.2)


def test_a_difference_within_the_gate_margin_is_accepted():
    def shifted(seconds):
        return shift_pose(true_pose(seconds), 0.014)

    exact = [SourceSettings(sigma_xy=1e-4, sigma_yaw=1e-4)] * 2
    for slack, is_used in ((0.005, True), (0.0, False)):
        arbiter = new_arbiter(2, exact, gate_margin_xy=slack)
        add_messages(arbiter, messages(0.3, [true_pose, shifted]))
        assert (arbiter.counts()[1, MeasurementStatus.USED] > 0) == is_used


def test_after_a_reset_nothing_is_known():
    arbiter = run(1.0, [noisy(1)])
    arbiter.reset()
    assert arbiter.estimate_at(BEGIN + SECOND) is None
    assert not arbiter.counts()
    add_messages(arbiter, messages(0.2, [noisy(1)]))
    assert max(errors(arbiter, 0.2)) < 0.02


@pytest.mark.parametrize('seed', [1, 2, 3])
def test_an_exact_source_is_accepted_although_the_yaw_slips_as_the_settings_say(seed):
    settings, rng = ArbiterSettings(), random.Random(seed)
    arbiter = new_arbiter(1, [SourceSettings(sigma_xy=1e-4, sigma_yaw=1e-4)])
    robot = odometry = SE2(0.0, 0.0, 0.0)
    step = 0.15 / 50.0  # slow: random error dominates
    for k in range(2000):
        slip = SE2(0.0, 0.0, settings.odometry_noise_yaw * math.sqrt(step) * rng.gauss(0.0, 1.0))
        robot, odometry = robot @ SE2(step, 0.0, 0.0), odometry @ SE2(step, 0.0, 0.0) @ slip
        stamp = BEGIN + k * SECOND // 50
        add_messages(arbiter, [(stamp, ODOMETRY, odometry), *([(stamp, 0, robot)] if k % 5 == 0 else [])])
    counts = arbiter.counts()
    assert counts[0, MeasurementStatus.USED] >= 0.99 * 400
    assert counts.get((0, MeasurementStatus.ODOMETRY_INCONSISTENT), 0) <= 4


def test_a_frequent_inaccurate_source_does_not_displace_a_rare_accurate_one():
    sources = [SourceSettings(sigma_xy=s, sigma_yaw=s) for s in (0.002, 0.03)]
    arbiter = new_arbiter(2, sources)
    often = messages(12.0, [lambda _: None, lambda s: shift_pose(true_pose(s), x=0.04, y=-0.04)])
    seldom = messages(12.0, [noisy(1, 0.002)], rate=1.0)
    said = {message[:2]: message for message in (*often, *seldom)}
    add_messages(arbiter, sorted(said.values(), key=lambda m: m[:1]))
    worst = max(errors(arbiter, 10.0 + k / 20)[0] for k in range(40))
    assert worst < 0.02  # the inaccurate source is 57 mm off


def test_while_the_robot_is_stationary_no_rejected_source_is_accepted_again():
    """A late source is inside the gate then, too."""

    def at(seconds):
        return min(seconds, 4.0) if seconds < 8.0 else seconds - 4.0

    def late(seconds):
        return true_pose(at(seconds - 0.5) if seconds > 2.0 else at(seconds))

    said = [m for m in messages(10.0, [lambda s: noisy(1)(at(s)), late]) if m[1] != ODOMETRY]
    said += [(BEGIN + k * SECOND // 50, ODOMETRY, odometry_pose(at(k / 50))) for k in range(501)]
    arbiter = new_arbiter(2)
    for stamp, source, pose in sorted(said, key=lambda m: m[0]):
        add_messages(arbiter, [(stamp, source, pose)])
        if stamp - BEGIN > 2.1 * SECOND and source == 1:
            assert arbiter.state_at(stamp).source_states[1].status is not MeasurementStatus.USED
    assert arbiter.counts()[1, MeasurementStatus.PROBATION] > 40


def test_without_odometry_a_rejected_source_is_accepted_again():
    arbiter = new_arbiter(2)
    add_messages(arbiter, [m for m in messages(8.0, [noisy(1), wrong_at_first]) if m[1] != ODOMETRY])
    assert arbiter.counts()[1, MeasurementStatus.OUTSIDE_GATE] > 20
    assert arbiter.state_at(BEGIN + 8 * SECOND).source_states[1].status is MeasurementStatus.USED
