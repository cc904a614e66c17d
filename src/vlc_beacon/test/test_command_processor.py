"""Zone rules are received outside and executed inside their zone."""

from __future__ import annotations

from dataclasses import replace

import pytest
from receptions import Memory, a_lamp

from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.authorization.decision import Accepted, RejectionReason
from vlc_beacon.core.packet.command_packet import Command, CommandPacket, Operation
from vlc_beacon.core.receiver.command_processor import CommandDecision, CommandProcessor
from vlc_beacon.core.receiver.tracked_lamp import LampObservation
from vlc_beacon.core.settings import AuthorizationSettings

KEY = CommandKey(bytes(range(32)))
SLOW = KEY.sign(Command(1, Operation.SLOW, 0.2, 5))
TURN = KEY.sign(Command(1, Operation.TURN, -1.5, 5))
SHOT = KEY.sign(Command(1, Operation.STOP, 0.0, 5, is_one_shot=True))


@pytest.fixture
def authorizer() -> CommandAuthorizer:
    return CommandAuthorizer(KEY, Memory(), {1: (0.0, 0.0)}, AuthorizationSettings(zone_radius=1.0))


def lamp(*commands: CommandPacket, beacon: int | None = 1) -> LampObservation:
    return replace(a_lamp(1, beacon), commands=commands)


def in_words(decisions: list[CommandDecision]) -> list[tuple[int, RejectionReason | None]]:
    return [
        (v.packet.command.operation, None if isinstance(v.outcome, Accepted) else v.outcome.reason)
        for v in decisions
    ]


def test_pending_rules_are_executed_in_their_zone_once_per_visit(authorizer: CommandAuthorizer) -> None:
    processor = CommandProcessor(authorizer)
    authorizer.update_position(0.0, (3.0, 0.0))
    far = [(Operation.SLOW, RejectionReason.WRONG_LOCATION), (Operation.TURN, RejectionReason.WRONG_LOCATION)]
    assert in_words(processor.process(0.0, [lamp(SLOW, TURN)])) == far
    assert processor.process(0.1, [lamp()]) == []
    obeyed = [(Operation.SLOW, None), (Operation.TURN, None)]
    for stamp in (1.0, 20.0):
        authorizer.update_position(stamp, (0.5, 0.0))
        assert in_words(processor.process(stamp, [lamp()])) == obeyed
        assert processor.process(stamp + 0.1, [lamp(SLOW)]) == []
        authorizer.update_position(stamp + 1.0, (3.0, 0.0))
        processor.process(stamp + 1.0, [lamp()])


def test_a_rule_waits_for_the_lamp_to_get_its_name(authorizer: CommandAuthorizer) -> None:
    processor = CommandProcessor(authorizer)
    authorizer.update_position(0.0, (0.0, 0.0))
    assert in_words(processor.process(0.0, [lamp(SLOW, beacon=None)])) == [
        (Operation.SLOW, RejectionReason.WRONG_BEACON)
    ]
    assert in_words(processor.process(0.1, [lamp()])) == [(Operation.SLOW, None)]


def test_a_one_shot_command_does_not_wait(authorizer: CommandAuthorizer) -> None:
    processor = CommandProcessor(authorizer)
    authorizer.update_position(0.0, (3.0, 0.0))
    assert in_words(processor.process(0.0, [lamp(SHOT)])) == [
        (Operation.STOP, RejectionReason.WRONG_LOCATION)
    ]
    authorizer.update_position(1.0, (0.0, 0.0))
    assert processor.process(1.0, [lamp()]) == []
    assert in_words(processor.process(1.1, [lamp(SHOT)])) == [(Operation.STOP, None)]


def test_a_lamp_that_is_gone_takes_its_rules_with_it(authorizer: CommandAuthorizer) -> None:
    processor = CommandProcessor(authorizer)
    authorizer.update_position(0.0, (3.0, 0.0))
    processor.process(0.0, [lamp(SLOW)])
    processor.process(0.1, [])
    authorizer.update_position(0.2, (0.0, 0.0))
    assert processor.process(0.2, [lamp()]) == []


def test_a_forged_packet_does_not_take_a_true_rule_away(authorizer: CommandAuthorizer) -> None:
    processor = CommandProcessor(authorizer)
    authorizer.update_position(0.0, (3.0, 0.0))
    processor.process(0.0, [lamp(SLOW)])
    forged = CommandPacket(SLOW.command, bytes(4))
    assert in_words(processor.process(0.1, [lamp(forged)])) == [(Operation.SLOW, RejectionReason.BAD_MAC)]
    authorizer.update_position(0.2, (0.5, 0.0))
    assert (Operation.SLOW, None) in in_words(processor.process(0.2, [lamp()]))


def test_pending_rules_survive_a_lockout(authorizer: CommandAuthorizer) -> None:
    processor = CommandProcessor(authorizer)
    authorizer.update_position(0.0, (3.0, 0.0))
    processor.process(0.0, [lamp(SLOW)])
    for k in range(8):
        processor.process(0.1 * k, [lamp(CommandPacket(TURN.command, bytes([k] * 4)))])
    authorizer.update_position(100.0, (0.5, 0.0))
    assert (Operation.SLOW, None) in in_words(processor.process(100.0, [lamp()]))
