"""Zone rules are received outside and executed inside their zone."""

from __future__ import annotations

from dataclasses import replace

import pytest
from receptions import a_lamp

from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.operation import Operation
from vlc_beacon.core.receiver.command_hearing import CommandHearing, Verdict
from vlc_beacon.core.receiver.light_receiver import ReadLamp
from vlc_beacon.core.trust.command_judge import CommandJudge
from vlc_beacon.core.trust.command_key import CommandKey
from vlc_beacon.core.trust.counters import Counters
from vlc_beacon.core.trust.trust_settings import TrustSettings
from vlc_beacon.core.trust.verdict import Accepted, Refusal

KEY = CommandKey(bytes(range(32)))
SLOW = KEY.sign(Command(1, Operation.SLOW, 0.2, 5))
TURN = KEY.sign(Command(1, Operation.TURN, -1.5, 5))
SHOT = KEY.sign(Command(1, Operation.STOP, 0.0, 5, is_one_shot=True))


class Memory:
    def __init__(self) -> None:
        self.counters = Counters()

    def read(self) -> Counters:
        return self.counters

    def write(self, counters: Counters) -> None:
        self.counters = counters


@pytest.fixture
def authorizer() -> CommandJudge:
    return CommandJudge(KEY, Memory(), {1: (0.0, 0.0)}, TrustSettings(zone_radius=1.0))


def lamp(*heard: CommandPacket, beacon: int | None = 1) -> ReadLamp:
    return replace(a_lamp(1, beacon), heard=heard)


def in_words(verdicts: list[Verdict]) -> list[tuple[int, Refusal | None]]:
    return [
        (v.packet.command.operation, None if isinstance(v.answer, Accepted) else v.answer.reason)
        for v in verdicts
    ]


def test_rules_that_were_heard_afar_are_obeyed_in_their_zone_once_a_visit(authorizer: CommandJudge) -> None:
    hearing = CommandHearing(authorizer)
    authorizer.robot_at(0.0, (3.0, 0.0))
    far = [(Operation.SLOW, Refusal.OTHER_PLACE), (Operation.TURN, Refusal.OTHER_PLACE)]
    assert in_words(hearing.hear(0.0, [lamp(SLOW, TURN)])) == far
    assert hearing.hear(0.1, [lamp()]) == []
    obeyed = [(Operation.SLOW, None), (Operation.TURN, None)]
    for stamp in (1.0, 20.0):
        authorizer.robot_at(stamp, (0.5, 0.0))
        assert in_words(hearing.hear(stamp, [lamp()])) == obeyed
        assert hearing.hear(stamp + 0.1, [lamp(SLOW)]) == []
        authorizer.robot_at(stamp + 1.0, (3.0, 0.0))
        hearing.hear(stamp + 1.0, [lamp()])


def test_a_rule_waits_for_the_lamp_to_get_its_name(authorizer: CommandJudge) -> None:
    hearing = CommandHearing(authorizer)
    authorizer.robot_at(0.0, (0.0, 0.0))
    assert in_words(hearing.hear(0.0, [lamp(SLOW, beacon=None)])) == [(Operation.SLOW, Refusal.OTHER_BEACON)]
    assert in_words(hearing.hear(0.1, [lamp()])) == [(Operation.SLOW, None)]


def test_a_one_shot_command_does_not_wait(authorizer: CommandJudge) -> None:
    hearing = CommandHearing(authorizer)
    authorizer.robot_at(0.0, (3.0, 0.0))
    assert in_words(hearing.hear(0.0, [lamp(SHOT)])) == [(Operation.STOP, Refusal.OTHER_PLACE)]
    authorizer.robot_at(1.0, (0.0, 0.0))
    assert hearing.hear(1.0, [lamp()]) == []
    assert in_words(hearing.hear(1.1, [lamp(SHOT)])) == [(Operation.STOP, None)]


def test_a_lamp_that_is_gone_takes_its_rules_with_it(authorizer: CommandJudge) -> None:
    hearing = CommandHearing(authorizer)
    authorizer.robot_at(0.0, (3.0, 0.0))
    hearing.hear(0.0, [lamp(SLOW)])
    hearing.hear(0.1, [])
    authorizer.robot_at(0.2, (0.0, 0.0))
    assert hearing.hear(0.2, [lamp()]) == []


def test_a_forged_packet_does_not_take_a_true_rule_away(authorizer: CommandJudge) -> None:
    hearing = CommandHearing(authorizer)
    authorizer.robot_at(0.0, (3.0, 0.0))
    hearing.hear(0.0, [lamp(SLOW)])
    forged = CommandPacket(SLOW.command, bytes(4))
    assert in_words(hearing.hear(0.1, [lamp(forged)])) == [(Operation.SLOW, Refusal.BAD_MAC)]
    authorizer.robot_at(0.2, (0.5, 0.0))
    assert (Operation.SLOW, None) in in_words(hearing.hear(0.2, [lamp()]))


def test_a_closed_ear_does_not_forget_what_it_heard(authorizer: CommandJudge) -> None:
    hearing = CommandHearing(authorizer)
    authorizer.robot_at(0.0, (3.0, 0.0))
    hearing.hear(0.0, [lamp(SLOW)])
    for k in range(8):
        hearing.hear(0.1 * k, [lamp(CommandPacket(TURN.command, bytes([k] * 4)))])
    authorizer.robot_at(100.0, (0.5, 0.0))
    assert (Operation.SLOW, None) in in_words(hearing.hear(100.0, [lamp()]))
