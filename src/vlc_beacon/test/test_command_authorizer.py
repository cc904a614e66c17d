import math
from dataclasses import replace

import numpy as np
import pytest

from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer, Lockout, ZoneVisits
from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.authorization.counters import Counters
from vlc_beacon.core.authorization.decision import Accepted, Rejected, RejectionReason
from vlc_beacon.core.packet.command_packet import Command, CommandPacket, Operation
from vlc_beacon.core.settings import AuthorizationSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

KEY = CommandKey(bytes(range(32)))
PLACES = {1: (0.0, 0.0), 2: (5.0, 0.0)}
SETTINGS = AuthorizationSettings(speed_limit=0.5, zone_radius=1.0)
RULE = Command(1, Operation.SLOW, 0.2, 5)
SHOT = Command(1, Operation.STOP, 0.0, 5, is_one_shot=True)


class Memory:
    """Counters that outlive an authorizer."""

    def __init__(self) -> None:
        self.counters, self.writes, self.error = Counters(), 0, ''

    def read(self) -> Counters:
        self.check()
        return self.counters

    def write(self, counters: Counters) -> None:
        self.check()
        self.counters, self.writes = counters, self.writes + 1

    def check(self) -> None:
        if self.error:
            raise VlcBeaconError(self.error)


def authorizer_at(
    position: tuple[float, float], memory: Memory | None = None, **changed: object
) -> CommandAuthorizer:
    authorizer = CommandAuthorizer(KEY, memory or Memory(), PLACES, replace(SETTINGS, **changed))
    authorizer.update_position(0.0, position)
    return authorizer


def refusal(decision: Accepted | Rejected) -> RejectionReason | None:
    return decision.reason if isinstance(decision, Rejected) else None


def test_a_signed_command_at_its_place_is_accepted() -> None:
    assert authorizer_at((0.3, 0.4)).authorize(KEY.sign(RULE), 1, 0.0) == Accepted(RULE)
    assert authorizer_at((0.3, 0.4)).authorize(KEY.sign(SHOT), 1, 0.0) == Accepted(SHOT)


def test_without_a_key_all_commands_are_rejected() -> None:
    authorizer = CommandAuthorizer(None, Memory(), PLACES, SETTINGS)
    authorizer.update_position(0.0, (0.0, 0.0))
    decision = authorizer.authorize(KEY.sign(RULE), 1, 0.0)
    assert decision == authorizer.permanent_rejection
    assert refusal(decision) is RejectionReason.NO_KEY
    assert authorizer_at((0.0, 0.0)).permanent_rejection is None


def test_a_forged_command_is_rejected() -> None:
    authorizer = authorizer_at((0.0, 0.0))
    assert refusal(authorizer.authorize(CommandPacket(RULE, b'abcd'), 1, 0.0)) is RejectionReason.BAD_MAC
    other = CommandKey(b'x' * 32).sign(RULE)
    assert refusal(authorizer.authorize(other, 1, 0.0)) is RejectionReason.BAD_MAC


@pytest.mark.parametrize('speaker', [2, None])
def test_commands_sent_by_another_lamp_are_rejected(speaker: int | None) -> None:
    assert (
        refusal(authorizer_at((0.0, 0.0)).authorize(KEY.sign(RULE), speaker, 0.0))
        is RejectionReason.WRONG_BEACON
    )


def test_commands_outside_the_zone_are_rejected_until_the_robot_is_nearer() -> None:
    authorizer = authorizer_at((1.1, 0.0))
    decision = authorizer.authorize(KEY.sign(RULE), 1, 0.0)
    assert refusal(decision) is RejectionReason.WRONG_LOCATION
    assert decision.message == 'command of beacon 1 at 1.1 m from it (zone_radius 1 m)'
    for outside in ((math.nan, 0.0), (0.8, 0.61)):
        authorizer.update_position(1.0, outside)
        assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 1.0)) is RejectionReason.WRONG_LOCATION
    authorizer.update_position(1.0, (0.6, 0.8))
    assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 1.0)) is None


def test_without_a_position_commands_are_rejected() -> None:
    authorizer = CommandAuthorizer(KEY, Memory(), PLACES, SETTINGS)
    assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 0.0)) is RejectionReason.NO_POSITION
    authorizer.update_position(0.0, (0.0, 0.0))
    assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 1.5)) is RejectionReason.NO_POSITION
    assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 0.9)) is None


def test_an_unknown_beacon_is_rejected() -> None:
    unknown_id = KEY.sign(replace(RULE, beacon=7))
    assert refusal(authorizer_at((0.0, 0.0)).authorize(unknown_id, 7, 0.0)) is RejectionReason.UNKNOWN_BEACON


def test_a_rule_is_done_once_a_visit() -> None:
    authorizer = authorizer_at((0.0, 0.0))
    turn = KEY.sign(Command(1, Operation.TURN, -1.570796, 5))
    assert [refusal(authorizer.authorize(KEY.sign(RULE), 1, 0.0)) for _ in range(3)] == [
        None,
        *[RejectionReason.ALREADY_EXECUTED] * 2,
    ]
    assert refusal(authorizer.authorize(turn, 1, 0.0)) is None
    authorizer.update_position(0.1, (1.5, 0.0))
    authorizer.update_position(0.2, (0.5, 0.0))
    assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 0.2)) is None


def test_a_one_shot_is_done_once() -> None:
    authorizer = authorizer_at((0.0, 0.0))
    newer = KEY.sign(replace(SHOT, counter=6))
    decisions = [
        authorizer.authorize(packet, 1, 0.0)
        for packet in (*[KEY.sign(SHOT)] * 2, newer, KEY.sign(SHOT), newer)
    ]
    expected = [None, RejectionReason.REPLAYED, None, RejectionReason.OLD_COUNTER, RejectionReason.REPLAYED]
    assert [refusal(decision) for decision in decisions] == expected
    authorizer.update_position(0.1, (9.0, 0.0))
    authorizer.update_position(0.2, (0.0, 0.0))
    assert refusal(authorizer.authorize(newer, 1, 0.2)) is RejectionReason.REPLAYED


def test_replays_are_rejected_after_a_restart() -> None:
    memory = Memory()
    before = authorizer_at((0.0, 0.0), memory)
    for command in (RULE, replace(RULE, counter=7), SHOT):
        assert refusal(before.authorize(KEY.sign(command), 1, 0.0)) is None
    after = authorizer_at((0.0, 0.0), memory)
    assert refusal(after.authorize(KEY.sign(RULE), 1, 0.0)) is RejectionReason.OLD_COUNTER
    assert refusal(after.authorize(KEY.sign(SHOT), 1, 0.0)) is RejectionReason.REPLAYED
    assert refusal(after.authorize(KEY.sign(replace(RULE, counter=7)), 1, 0.0)) is None


def test_only_news_is_written() -> None:
    memory = Memory()
    authorizer = authorizer_at((0.0, 0.0), memory)
    for stamp in np.arange(50) * 0.01:
        authorizer.update_position(stamp, (9.0 * (round(100 * stamp) % 2), 0.0))
        authorizer.authorize(KEY.sign(RULE), 1, stamp)
    assert memory.writes == 1


def test_lost_counters_reject_all_commands_with_their_reason() -> None:
    memory = Memory()
    memory.error = 'counter file c.json is missing; renew it'
    authorizer = authorizer_at((0.0, 0.0), memory)
    decision = authorizer.authorize(KEY.sign(RULE), 1, 0.0)
    expected = 'commands are rejected: counter file c.json is missing; renew it'
    assert decision == authorizer.permanent_rejection == Rejected(RejectionReason.COUNTERS_LOST, expected)


def test_what_cannot_be_kept_is_not_done() -> None:
    memory = Memory()
    authorizer = authorizer_at((0.0, 0.0), memory)
    memory.error = 'the disk is full'
    assert refusal(authorizer.authorize(KEY.sign(SHOT), 1, 0.0)) is RejectionReason.COUNTERS_LOST
    memory.error = ''
    assert refusal(authorizer.authorize(KEY.sign(SHOT), 1, 0.0)) is None


def test_too_many_forgeries_lock_and_the_lock_opens() -> None:
    authorizer = authorizer_at((0.0, 0.0), bad_macs_max=3, lockout_time=60.0, position_age_max=60.0)
    for _ in range(3):
        authorizer.authorize(CommandPacket(RULE, b'abcd'), 1, 0.0)
    decision = authorizer.authorize(KEY.sign(RULE), 1, 1.0)
    assert decision == Rejected(
        RejectionReason.LOCKED_OUT, 'commands are rejected for 60 s after too many wrong authentication codes'
    )
    authorizer.update_position(60.0, (0.0, 0.0))
    assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 60.0)) is None


def test_the_speed_limit_holds_whatever_is_signed() -> None:
    fast = Command(1, Operation.SPEED_UP, 1.9, 5)
    assert authorizer_at((0.0, 0.0)).authorize(KEY.sign(fast), 1, 0.0) == Accepted(replace(fast, value=0.5))


def test_implausible_commands_are_rejected_and_do_not_advance_the_counter() -> None:
    memory = Memory()
    authorizer = authorizer_at((0.0, 0.0), memory)
    wild = KEY.sign(Command(1, Operation.TURN, 100.0, 9))
    assert refusal(authorizer.authorize(wild, 1, 0.0)) is RejectionReason.IMPLAUSIBLE
    assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 0.0)) is None


def test_daily_life_is_not_suspicious() -> None:
    daily = {'ALREADY_EXECUTED', 'REPLAYED', 'WRONG_LOCATION', 'NO_KEY'}
    attacks = {'BAD_MAC', 'OLD_COUNTER', 'WRONG_BEACON'}
    suspicious = {reason.name for reason in RejectionReason if reason.is_suspicious}
    assert attacks <= suspicious
    assert not daily & suspicious


def test_after_a_jump_back_in_time_visits_are_reset_but_counters_are_kept() -> None:
    memory = Memory()
    authorizer = authorizer_at((0.0, 0.0), memory)
    assert authorizer.authorize(KEY.sign(RULE), 1, 0.0) == Accepted(RULE)
    assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 0.0)) is RejectionReason.ALREADY_EXECUTED
    authorizer.reset_position()
    assert refusal(authorizer.authorize(KEY.sign(RULE), 1, 0.0)) is RejectionReason.NO_POSITION
    authorizer.update_position(0.0, (0.0, 0.0))
    assert authorizer.authorize(KEY.sign(RULE), 1, 0.0) == Accepted(RULE)
    older = replace(RULE, counter=RULE.counter - 1)
    assert refusal(authorizer.authorize(KEY.sign(older), 1, 0.0)) is RejectionReason.OLD_COUNTER


def test_few_in_a_long_time_do_not_close_it() -> None:
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
    visits = ZoneVisits({1: (0.0, 0.0), 2: (5.0, 0.0)}, 1.0)
    first, second = Command(1, 3, 0.2, 5), Command(1, 5, 1.0, 5)
    visits.update_position((0.5, 0.0))
    visits.mark_executed(first)
    assert visits.is_executed(first)
    assert not visits.is_executed(second)
    assert not visits.is_executed(Command(2, 3, 0.2, 5))
    for x in (0.9, 1.1, 0.9, 1.2):
        visits.update_position((x, 0.0))
        assert visits.is_executed(first)
    visits.update_position((1.3, 0.0))
    assert not visits.is_executed(first)
