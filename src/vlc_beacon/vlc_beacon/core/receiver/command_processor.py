"""Passes commands of lamps to the authorizer, again for each image until they are accepted.

Decoding a zone rule takes seconds, mostly on the way to its zone: the last rules of each lamp are kept as pending and
authorized again with each image, so that they are executed as soon as the robot enters the zone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from vlc_beacon.core.authorization.command_authorizer import Accepted, CommandAuthorizer, Rejected, RejectionReason
from vlc_beacon.core.packet.command_packet import CommandPacket
from vlc_beacon.core.receiver.light_receiver import LampObservation

_RETRY_REASONS = (RejectionReason.NO_POSITION, RejectionReason.WRONG_LOCATION, RejectionReason.ALREADY_EXECUTED)
"""Rejections of rules that may be accepted later."""
_TEMPORARY_REASONS = (RejectionReason.LOCKED_OUT, RejectionReason.COUNTERS_LOST)
"""Temporary rejections that apply to all commands."""


@dataclass(frozen=True)
class CommandDecision:
    """Decision on a command, with the ID of the lamp that sent it, None while unconfirmed."""

    packet: CommandPacket
    sender: int | None
    outcome: Accepted | Rejected


class CommandProcessor:
    """Passes the commands of all lamps to the authorizer."""

    def __init__(self, authorizer: CommandAuthorizer) -> None:
        self._authorizer = authorizer
        self._pending: dict[int, dict[int, CommandPacket]] = {}
        self._reported: dict[tuple[int, int], RejectionReason] = {}

    def process(self, stamp: float, lamps: Sequence[LampObservation]) -> list[CommandDecision]:
        """Return the new decisions: accepted commands, and rejections whose reason has changed."""
        keys = {lamp.sample.key for lamp in lamps}
        self._pending = {key: pending for key, pending in self._pending.items() if key in keys}
        self._reported = {place: reason for place, reason in self._reported.items() if place[0] in keys}
        decisions = []
        for lamp in lamps:
            pending = tuple(self._pending.get(lamp.sample.key, {}).values())
            # A received command replaces a pending one only after it has been authenticated.
            for packet in dict.fromkeys((*pending, *lamp.commands)):
                decision = self._authorize(stamp, lamp, packet)
                if decision is not None:
                    decisions.append(decision)
        return decisions

    def _authorize(self, stamp: float, lamp: LampObservation, packet: CommandPacket) -> CommandDecision | None:
        """Return the decision on a command if it is new, and keep the command if it may be accepted later."""
        key, operation = lamp.sample.key, packet.command.operation
        outcome = self._authorizer.authorize(packet, lamp.beacon, stamp)
        pending = self._pending.setdefault(key, {})
        if self._should_retry(lamp, packet, outcome):
            pending[operation] = packet
        elif pending.get(operation) == packet:
            del pending[operation]
        if isinstance(outcome, Accepted):
            self._reported.pop((key, operation), None)
            return CommandDecision(packet, lamp.beacon, outcome)
        # Do not report a repeated rule that was executed already.
        if outcome.reason in (self._reported.get((key, operation)), RejectionReason.ALREADY_EXECUTED):
            return None
        self._reported[key, operation] = outcome.reason
        return CommandDecision(packet, lamp.beacon, outcome)

    def _should_retry(self, lamp: LampObservation, packet: CommandPacket, outcome: Accepted | Rejected) -> bool:
        # One-shot commands are repeated by the sender; a delayed one must not be executed.
        if packet.command.is_one_shot:
            return False
        if isinstance(outcome, Accepted) or outcome.reason in _RETRY_REASONS:
            return True
        if outcome.reason in _TEMPORARY_REASONS:
            # The rejection is independent of the command: keep one that is pending already.
            return self._pending[lamp.sample.key].get(packet.command.operation) == packet
        return outcome.reason is RejectionReason.WRONG_BEACON and lamp.beacon is None
