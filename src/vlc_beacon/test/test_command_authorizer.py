import math
from dataclasses import replace

import numpy as np
import pytest
from receptions import KEY, Memory

from vlc_beacon.core.authorization.command_authorizer import (
    Accepted,
    CommandAuthorizer,
    Lockout,
    Rejected,
    RejectionReason,
    ZoneVisits,
)
from vlc_beacon.core.authorization.keys_and_counters import CommandKey
from vlc_beacon.core.packet.command_packet import Command, CommandPacket, Operation
from vlc_beacon.core.settings import AuthorizationSettings

PLACES = {1: (0.0, 0.0), 2: (5.0, 0.0)}
SETTINGS = AuthorizationSettings(speed_limit=0.5, zone_radius=1.0)
RULE = Command(1, Operation.SLOW, 0.2, 5)
SHOT = Command(1, Operation.STOP, 0.0, 5, is_one_shot=True)
FORGED = CommandPacket(RULE, b'abcd')


def authorizer_at(*position: float, memory: Memory | None = None, **changed: object) -> CommandAuthorizer:
    authorizer = CommandAuthorizer(KEY, memory or Memory(), PLACES, replace(SETTINGS, **changed))
    authorizer.update_position(0.0, position)
    return authorizer


def refusal(authorizer, command, stamp=0.0, sender=1) -> RejectionReason | None:
    """Return why a packet, or a command that is signed, is rejected."""
    packet = KEY.sign(command) if isinstance(command, Command) else command
    decision = authorizer.authorize(packet, sender, stamp)
    return decision.reason if isinstance(decision, Rejected) else None


@pytest.mark.parametrize(
    ('command', 'sender', 'reason'),
    [
        (RULE, 1, None),
        (SHOT, 1, None),
        (FORGED, 1, RejectionReason.BAD_MAC),
        (CommandKey(b'x' * 32).sign(RULE), 1, RejectionReason.BAD_MAC),
        (RULE, 2, RejectionReason.WRONG_BEACON),
        (RULE, None, RejectionReason.WRONG_BEACON),
        (replace(RULE, beacon=7), 7, RejectionReason.UNKNOWN_BEACON),
        (Command(1, Operation.TURN, 100.0, 9), 1, RejectionReason.IMPLAUSIBLE),
    ],
)
def test_only_signed_plausible_commands_of_their_lamp_are_accepted(command, sender, reason) -> None:
    authorizer = authorizer_at(0.3, 0.4)
    assert refusal(authorizer, command, sender=sender) is reason
    # A rejected command does not advance the counter.
    assert reason is None or refusal(authorizer, RULE) is None


def test_a_command_is_accepted_as_it_was_signed_but_within_the_speed_limit() -> None:
    assert authorizer_at(0.3, 0.4).authorize(KEY.sign(SHOT), 1, 0.0) == Accepted(SHOT)
    fast = Command(1, Operation.SPEED_UP, 1.9, 5)
    assert authorizer_at(0.0, 0.0).authorize(KEY.sign(fast), 1, 0.0) == Accepted(replace(fast, value=0.5))


def test_without_a_key_or_counters_all_commands_are_rejected_with_the_reason() -> None:
    lost = 'commands are rejected: counter file c.json is missing; renew it'
    memory = Memory('counter file c.json is missing; renew it')
    for key, store, reason in ((None, Memory(), RejectionReason.NO_KEY), (KEY, memory, RejectionReason.COUNTERS_LOST)):
        authorizer = CommandAuthorizer(key, store, PLACES, SETTINGS)
        authorizer.update_position(0.0, (0.0, 0.0))
        decision = authorizer.authorize(KEY.sign(RULE), 1, 0.0)
        assert decision == authorizer.permanent_rejection
        assert decision.reason is reason
    assert decision.message == lost
    assert authorizer_at(0.0, 0.0).permanent_rejection is None


def test_commands_outside_the_zone_are_rejected_until_the_robot_is_nearer() -> None:
    authorizer = authorizer_at(1.1, 0.0)
    decision = authorizer.authorize(KEY.sign(RULE), 1, 0.0)
    assert decision.reason is RejectionReason.WRONG_LOCATION
    assert decision.message == 'command of beacon 1 at 1.1 m from it (zone_radius 1 m)'
    for outside in ((math.nan, 0.0), (0.8, 0.61)):
        authorizer.update_position(1.0, outside)
        assert refusal(authorizer, RULE, 1.0) is RejectionReason.WRONG_LOCATION
    authorizer.update_position(1.0, (0.6, 0.8))
    assert refusal(authorizer, RULE, 1.0) is None


def test_without_a_position_commands_are_rejected() -> None:
    authorizer = CommandAuthorizer(KEY, Memory(), PLACES, SETTINGS)
    assert refusal(authorizer, RULE) is RejectionReason.NO_POSITION
    authorizer.update_position(0.0, (0.0, 0.0))
    assert refusal(authorizer, RULE, 1.5) is RejectionReason.NO_POSITION
    assert refusal(authorizer, RULE, 0.9) is None


def test_a_rule_is_done_once_a_visit() -> None:
    authorizer = authorizer_at(0.0, 0.0)
    again = RejectionReason.ALREADY_EXECUTED
    assert [refusal(authorizer, RULE) for _ in range(3)] == [None, again, again]
    assert refusal(authorizer, Command(1, Operation.TURN, -1.570796, 5)) is None
    authorizer.update_position(0.1, (1.5, 0.0))
    authorizer.update_position(0.2, (0.5, 0.0))
    assert refusal(authorizer, RULE, 0.2) is None


def test_a_one_shot_is_done_once() -> None:
    authorizer, newer = authorizer_at(0.0, 0.0), replace(SHOT, counter=6)
    expected = [None, RejectionReason.REPLAYED, None, RejectionReason.OLD_COUNTER, RejectionReason.REPLAYED]
    assert [refusal(authorizer, shot) for shot in (SHOT, SHOT, newer, SHOT, newer)] == expected
    authorizer.update_position(0.1, (9.0, 0.0))
    authorizer.update_position(0.2, (0.0, 0.0))
    assert refusal(authorizer, newer, 0.2) is RejectionReason.REPLAYED


def test_replays_are_rejected_after_a_restart() -> None:
    memory, newer = Memory(), replace(RULE, counter=7)
    before = authorizer_at(0.0, 0.0, memory=memory)
    assert [refusal(before, command) for command in (RULE, newer, SHOT)] == [None] * 3
    after = authorizer_at(0.0, 0.0, memory=memory)
    expected = [RejectionReason.OLD_COUNTER, RejectionReason.REPLAYED, None]
    assert [refusal(after, command) for command in (RULE, SHOT, newer)] == expected


def test_only_news_is_written() -> None:
    memory = Memory()
    authorizer = authorizer_at(0.0, 0.0, memory=memory)
    for stamp in np.arange(50) * 0.01:
        authorizer.update_position(stamp, (9.0 * (round(100 * stamp) % 2), 0.0))
        refusal(authorizer, RULE, stamp)
    assert memory.writes == 1


def test_what_cannot_be_kept_is_not_done() -> None:
    memory = Memory()
    authorizer = authorizer_at(0.0, 0.0, memory=memory)
    memory.error = 'the disk is full'
    assert refusal(authorizer, SHOT) is RejectionReason.COUNTERS_LOST
    memory.error = ''
    assert refusal(authorizer, SHOT) is None


def test_too_many_forgeries_lock_and_the_lock_opens() -> None:
    authorizer = authorizer_at(0.0, 0.0, bad_macs_max=3, lockout_time=60.0, position_age_max=60.0)
    for _ in range(3):
        refusal(authorizer, FORGED)
    message = 'commands are rejected for 60 s after too many wrong authentication codes'
    assert authorizer.authorize(KEY.sign(RULE), 1, 1.0) == Rejected(RejectionReason.LOCKED_OUT, message)
    authorizer.update_position(60.0, (0.0, 0.0))
    assert refusal(authorizer, RULE, 60.0) is None


def test_daily_life_is_not_suspicious() -> None:
    daily = {'ALREADY_EXECUTED', 'REPLAYED', 'WRONG_LOCATION', 'NO_KEY'}
    suspicious = {reason.name for reason in RejectionReason if reason.is_suspicious}
    assert suspicious >= {'BAD_MAC', 'OLD_COUNTER', 'WRONG_BEACON'}
    assert not daily & suspicious


def test_after_a_jump_back_in_time_visits_are_reset_but_counters_are_kept() -> None:
    authorizer = authorizer_at(0.0, 0.0)
    assert [refusal(authorizer, RULE) for _ in range(2)] == [None, RejectionReason.ALREADY_EXECUTED]
    authorizer.reset_position()
    assert refusal(authorizer, RULE) is RejectionReason.NO_POSITION
    authorizer.update_position(0.0, (0.0, 0.0))
    assert refusal(authorizer, RULE) is None
    assert refusal(authorizer, replace(RULE, counter=4)) is RejectionReason.OLD_COUNTER


def test_few_failures_in_a_long_time_do_not_lock() -> None:
    lockout = Lockout(3, 60.0)
    for k in range(100):
        lockout.add_failure(31.0 * k)
        assert not lockout.is_locked(31.0 * k)


def test_guesses_are_bounded_in_any_time() -> None:
    lockout, guesses = Lockout(5, 60.0), 0
    for second in range(3600):
        if not lockout.is_locked(second):
            lockout.add_failure(second)
            guesses += 1
    assert guesses <= 5 * 61


def test_a_clock_that_is_set_back_does_not_lock_for_ever() -> None:
    lockout = Lockout(1, 60.0)
    lockout.add_failure(1e9)
    assert lockout.is_locked(1e9 + 1.0)
    assert not lockout.is_locked(5.0)


def test_a_rule_is_done_until_the_zone_is_left_for_good() -> None:
    visits = ZoneVisits(PLACES, 1.0)
    first, second = Command(1, 3, 0.2, 5), Command(1, 5, 1.0, 5)
    visits.update_position((0.5, 0.0))
    visits.mark_executed(first)
    assert not visits.is_executed(second)
    assert not visits.is_executed(Command(2, 3, 0.2, 5))
    for x in (0.5, 0.9, 1.1, 0.9, 1.2):
        visits.update_position((x, 0.0))
        assert visits.is_executed(first)
    visits.update_position((1.3, 0.0))
    assert not visits.is_executed(first)
