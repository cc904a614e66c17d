"""Zone rules are received outside and executed inside their zone."""

from dataclasses import replace

from receptions import KEY, Memory, a_lamp

from vlc_beacon.core.authorization.command_authorizer import Accepted, CommandAuthorizer, RejectionReason
from vlc_beacon.core.packet.command_packet import Command, CommandPacket, Operation
from vlc_beacon.core.receiver.command_processor import CommandProcessor
from vlc_beacon.core.receiver.light_receiver import LampObservation
from vlc_beacon.core.settings import AuthorizationSettings

SLOW = KEY.sign(Command(1, Operation.SLOW, 0.2, 5))
TURN = KEY.sign(Command(1, Operation.TURN, -1.5, 5))
SHOT = KEY.sign(Command(1, Operation.STOP, 0.0, 5, is_one_shot=True))


def lamp(*commands: CommandPacket, beacon: int | None = 1) -> LampObservation:
    return replace(a_lamp(1, beacon), commands=commands)


class Robot:
    """A robot under a lamp at the origin, whose zone has a radius of 1 m."""

    def __init__(self) -> None:
        self.authorizer = CommandAuthorizer(KEY, Memory(), {1: (0.0, 0.0)}, AuthorizationSettings(zone_radius=1.0))
        self.processor = CommandProcessor(self.authorizer)

    def at(self, stamp: float, x: float, *lamps: LampObservation) -> list[tuple[int, RejectionReason | None]]:
        """Return the operations that are decided on, and why those are rejected that are."""
        self.authorizer.update_position(stamp, (x, 0.0))
        return [
            (v.packet.command.operation, None if isinstance(v.outcome, Accepted) else v.outcome.reason)
            for v in self.processor.process(stamp, list(lamps))
        ]


OBEYED = (Operation.SLOW, None)
FAR = RejectionReason.WRONG_LOCATION


def test_pending_rules_are_executed_in_their_zone_once_per_visit() -> None:
    robot = Robot()
    assert robot.at(0.0, 3.0, lamp(SLOW, TURN)) == [(Operation.SLOW, FAR), (Operation.TURN, FAR)]
    assert robot.at(0.1, 3.0, lamp()) == []
    for stamp in (1.0, 20.0):
        assert robot.at(stamp, 0.5, lamp()) == [OBEYED, (Operation.TURN, None)]
        assert robot.at(stamp + 0.1, 0.5, lamp(SLOW)) == []
        robot.at(stamp + 1.0, 3.0, lamp())


def test_a_rule_waits_for_the_lamp_to_get_its_name() -> None:
    robot, too_early = Robot(), (Operation.SLOW, RejectionReason.WRONG_BEACON)
    assert robot.at(0.0, 0.0, lamp(SLOW, beacon=None)) == [too_early]
    assert robot.at(0.1, 0.0, lamp()) == [OBEYED]


def test_a_one_shot_command_does_not_wait() -> None:
    robot = Robot()
    assert robot.at(0.0, 3.0, lamp(SHOT)) == [(Operation.STOP, FAR)]
    assert robot.at(1.0, 0.0, lamp()) == []
    assert robot.at(1.1, 0.0, lamp(SHOT)) == [(Operation.STOP, None)]


def test_a_lamp_that_is_gone_takes_its_rules_with_it() -> None:
    robot = Robot()
    robot.at(0.0, 3.0, lamp(SLOW))
    robot.at(0.1, 3.0)
    assert robot.at(0.2, 0.0, lamp()) == []


def test_forged_packets_and_a_lockout_do_not_take_a_true_rule_away() -> None:
    robot = Robot()
    robot.at(0.0, 3.0, lamp(SLOW))
    forged = CommandPacket(SLOW.command, bytes(4))
    assert robot.at(0.1, 3.0, lamp(forged)) == [(Operation.SLOW, RejectionReason.BAD_MAC)]
    assert OBEYED in robot.at(0.2, 0.5, lamp())
    robot = Robot()
    robot.at(0.0, 3.0, lamp(SLOW))
    for k in range(8):
        robot.at(0.1 * k, 3.0, lamp(CommandPacket(TURN.command, bytes([k] * 4))))
    assert OBEYED in robot.at(100.0, 0.5, lamp())
