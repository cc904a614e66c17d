from dataclasses import replace

import numpy as np
import pytest

from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.operation import Operation
from vlc_beacon.core.trust.command_judge import CommandJudge
from vlc_beacon.core.trust.command_key import CommandKey
from vlc_beacon.core.trust.counters import Counters
from vlc_beacon.core.trust.trust_settings import TrustSettings
from vlc_beacon.core.trust.verdict import Accepted, Refusal, Refused
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

KEY = CommandKey(bytes(range(32)))
PLACES = {1: (0.0, 0.0), 2: (5.0, 0.0)}
SETTINGS = TrustSettings(speed_limit=0.5, zone_radius=1.0)
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


def judge_at(position: tuple[float, float], memory: Memory | None = None, **changed: object) -> CommandJudge:
    authorizer = CommandJudge(KEY, memory or Memory(), PLACES, replace(SETTINGS, **changed))
    authorizer.robot_at(0.0, position)
    return authorizer


def refusal(verdict: Accepted | Refused) -> Refusal | None:
    return verdict.reason if isinstance(verdict, Refused) else None


def test_a_signed_command_at_its_place_is_accepted() -> None:
    assert judge_at((0.3, 0.4)).judge(KEY.sign(RULE), 1, 0.0) == Accepted(RULE)
    assert judge_at((0.3, 0.4)).judge(KEY.sign(SHOT), 1, 0.0) == Accepted(SHOT)


def test_without_a_key_all_is_refused() -> None:
    authorizer = CommandJudge(None, Memory(), PLACES, SETTINGS)
    authorizer.robot_at(0.0, (0.0, 0.0))
    verdict = authorizer.judge(KEY.sign(RULE), 1, 0.0)
    assert verdict == authorizer.standing_refusal
    assert refusal(verdict) is Refusal.NO_KEY
    assert judge_at((0.0, 0.0)).standing_refusal is None


def test_a_forged_command_is_refused() -> None:
    authorizer = judge_at((0.0, 0.0))
    assert refusal(authorizer.judge(CommandPacket(RULE, b'abcd'), 1, 0.0)) is Refusal.BAD_MAC
    other = CommandKey(b'x' * 32).sign(RULE)
    assert refusal(authorizer.judge(other, 1, 0.0)) is Refusal.BAD_MAC


@pytest.mark.parametrize('speaker', [2, None])
def test_another_lamp_cannot_speak_for_a_beacon(speaker: int | None) -> None:
    assert refusal(judge_at((0.0, 0.0)).judge(KEY.sign(RULE), speaker, 0.0)) is Refusal.OTHER_BEACON


def test_another_place_is_refused_and_may_be_judged_again_nearer() -> None:
    authorizer = judge_at((1.1, 0.0))
    verdict = authorizer.judge(KEY.sign(RULE), 1, 0.0)
    assert refusal(verdict) is Refusal.OTHER_PLACE
    assert verdict.message == 'command of beacon 1 at 1.1 m from it (zone_radius 1 m)'
    authorizer.robot_at(1.0, (0.9, 0.0))
    assert refusal(authorizer.judge(KEY.sign(RULE), 1, 1.0)) is None


def test_a_robot_that_does_not_know_where_it_is_refuses() -> None:
    authorizer = CommandJudge(KEY, Memory(), PLACES, SETTINGS)
    assert refusal(authorizer.judge(KEY.sign(RULE), 1, 0.0)) is Refusal.NO_POSITION
    authorizer.robot_at(0.0, (0.0, 0.0))
    assert refusal(authorizer.judge(KEY.sign(RULE), 1, 1.5)) is Refusal.NO_POSITION
    assert refusal(authorizer.judge(KEY.sign(RULE), 1, 0.9)) is None


def test_a_beacon_that_is_not_known_is_refused() -> None:
    stranger = KEY.sign(replace(RULE, beacon=7))
    assert refusal(judge_at((0.0, 0.0)).judge(stranger, 7, 0.0)) is Refusal.UNKNOWN_BEACON


def test_a_rule_is_done_once_a_visit() -> None:
    authorizer = judge_at((0.0, 0.0))
    turn = KEY.sign(Command(1, Operation.TURN, -1.570796, 5))
    assert [refusal(authorizer.judge(KEY.sign(RULE), 1, 0.0)) for _ in range(3)] == [
        None,
        *[Refusal.DONE] * 2,
    ]
    assert refusal(authorizer.judge(turn, 1, 0.0)) is None
    authorizer.robot_at(0.1, (1.5, 0.0))
    authorizer.robot_at(0.2, (0.5, 0.0))
    assert refusal(authorizer.judge(KEY.sign(RULE), 1, 0.2)) is None


def test_a_one_shot_is_done_once() -> None:
    authorizer = judge_at((0.0, 0.0))
    newer = KEY.sign(replace(SHOT, counter=6))
    verdicts = [
        authorizer.judge(packet, 1, 0.0) for packet in (*[KEY.sign(SHOT)] * 2, newer, KEY.sign(SHOT), newer)
    ]
    expected = [None, Refusal.REPEATED, None, Refusal.OLD_COUNTER, Refusal.REPEATED]
    assert [refusal(verdict) for verdict in verdicts] == expected
    authorizer.robot_at(0.1, (9.0, 0.0))
    authorizer.robot_at(0.2, (0.0, 0.0))
    assert refusal(authorizer.judge(newer, 1, 0.2)) is Refusal.REPEATED


def test_replays_are_refused_after_a_restart_too() -> None:
    memory = Memory()
    before = judge_at((0.0, 0.0), memory)
    for command in (RULE, replace(RULE, counter=7), SHOT):
        assert refusal(before.judge(KEY.sign(command), 1, 0.0)) is None
    after = judge_at((0.0, 0.0), memory)
    assert refusal(after.judge(KEY.sign(RULE), 1, 0.0)) is Refusal.OLD_COUNTER
    assert refusal(after.judge(KEY.sign(SHOT), 1, 0.0)) is Refusal.REPEATED
    assert refusal(after.judge(KEY.sign(replace(RULE, counter=7)), 1, 0.0)) is None


def test_only_news_is_written() -> None:
    memory = Memory()
    authorizer = judge_at((0.0, 0.0), memory)
    for stamp in np.arange(50) * 0.01:
        authorizer.robot_at(stamp, (9.0 * (round(100 * stamp) % 2), 0.0))
        authorizer.judge(KEY.sign(RULE), 1, stamp)
    assert memory.writes == 1


def test_lost_counters_refuse_all_with_their_reason() -> None:
    memory = Memory()
    memory.error = 'counter file c.json is missing; renew it'
    authorizer = judge_at((0.0, 0.0), memory)
    verdict = authorizer.judge(KEY.sign(RULE), 1, 0.0)
    expected = 'commands are rejected: counter file c.json is missing; renew it'
    assert verdict == authorizer.standing_refusal == Refused(Refusal.COUNTERS_LOST, expected)


def test_what_cannot_be_kept_is_not_done() -> None:
    memory = Memory()
    authorizer = judge_at((0.0, 0.0), memory)
    memory.error = 'the disk is full'
    assert refusal(authorizer.judge(KEY.sign(SHOT), 1, 0.0)) is Refusal.COUNTERS_LOST
    memory.error = ''
    assert refusal(authorizer.judge(KEY.sign(SHOT), 1, 0.0)) is None


def test_too_many_forgeries_lock_and_the_lock_opens() -> None:
    authorizer = judge_at((0.0, 0.0), bad_macs_max=3, lockout_time=60.0, position_age_max=60.0)
    for _ in range(3):
        authorizer.judge(CommandPacket(RULE, b'abcd'), 1, 0.0)
    verdict = authorizer.judge(KEY.sign(RULE), 1, 1.0)
    assert verdict == Refused(
        Refusal.LOCKED, 'commands are rejected for 60 s after too many wrong authentication codes'
    )
    authorizer.robot_at(60.0, (0.0, 0.0))
    assert refusal(authorizer.judge(KEY.sign(RULE), 1, 60.0)) is None


def test_the_speed_limit_holds_whatever_is_signed() -> None:
    fast = Command(1, Operation.SPEED_UP, 1.9, 5)
    assert judge_at((0.0, 0.0)).judge(KEY.sign(fast), 1, 0.0) == Accepted(replace(fast, value=0.5))


def test_nonsense_is_refused_and_costs_no_counter() -> None:
    memory = Memory()
    authorizer = judge_at((0.0, 0.0), memory)
    wild = KEY.sign(Command(1, Operation.TURN, 100.0, 9))
    assert refusal(authorizer.judge(wild, 1, 0.0)) is Refusal.IMPLAUSIBLE
    assert refusal(authorizer.judge(KEY.sign(RULE), 1, 0.0)) is None


def test_daily_life_is_not_suspicious() -> None:
    assert not any(
        r.is_suspicious for r in (Refusal.DONE, Refusal.REPEATED, Refusal.OTHER_PLACE, Refusal.NO_KEY)
    )
    assert all(r.is_suspicious for r in (Refusal.BAD_MAC, Refusal.OLD_COUNTER, Refusal.OTHER_BEACON))


def test_after_a_jump_back_in_time_a_visit_begins_anew_but_counters_stay() -> None:
    memory = Memory()
    authorizer = judge_at((0.0, 0.0), memory)
    assert authorizer.judge(KEY.sign(RULE), 1, 0.0) == Accepted(RULE)
    assert refusal(authorizer.judge(KEY.sign(RULE), 1, 0.0)) is Refusal.DONE
    authorizer.forget_place()
    assert refusal(authorizer.judge(KEY.sign(RULE), 1, 0.0)) is Refusal.NO_POSITION
    authorizer.robot_at(0.0, (0.0, 0.0))
    assert authorizer.judge(KEY.sign(RULE), 1, 0.0) == Accepted(RULE)
    older = replace(RULE, counter=RULE.counter - 1)
    assert refusal(authorizer.judge(KEY.sign(older), 1, 0.0)) is Refusal.OLD_COUNTER
