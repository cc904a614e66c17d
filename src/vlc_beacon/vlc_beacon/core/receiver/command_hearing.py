"""Passes commands of lamps to the authorizer, again for each image until they are accepted.

Decoding a zone rule takes seconds, mostly on the way to its zone: the last rules of each lamp are kept as pending and
authorized again with each image, so that they are executed as soon as the robot enters the zone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vlc_beacon.core.packet.command_packet import CommandPacket
from vlc_beacon.core.receiver.light_receiver import ReadLamp
from vlc_beacon.core.trust.command_judge import CommandJudge
from vlc_beacon.core.trust.verdict import Accepted, Refusal, Refused

_WAITING = (Refusal.NO_POSITION, Refusal.OTHER_PLACE, Refusal.DONE)
"""Rejections of rules that may be accepted later."""
_PASSING = (Refusal.LOCKED, Refusal.COUNTERS_LOST)
"""Temporary rejections that apply to all commands."""


@dataclass(frozen=True)
class Verdict:
    """Decision on a command.

    Attributes:
        packet: the command packet.
        speaker: ID of the lamp that sent it, None while unconfirmed.
        answer: result of the authorization.
    """

    packet: CommandPacket
    speaker: int | None
    answer: Accepted | Refused


class CommandHearing:
    """Passes the commands of all lamps to the authorizer."""

    def __init__(self, authorizer: CommandJudge) -> None:
        """Start without commands.

        Args:
            authorizer: authorizer of commands.
        """
        self._authorizer = authorizer
        self._kept: dict[int, dict[int, CommandPacket]] = {}
        self._told: dict[tuple[int, int], Refusal] = {}

    def hear(self, stamp: float, lamps: Sequence[ReadLamp]) -> list[Verdict]:
        """Return the new decisions: accepted commands, and rejections whose reason has changed.

        Args:
            stamp: stamp of the image [s].
            lamps: lamps in the image.
        """
        keys = {lamp.sample.key for lamp in lamps}
        self._kept = {key: kept for key, kept in self._kept.items() if key in keys}
        self._told = {place: reason for place, reason in self._told.items() if place[0] in keys}
        verdicts = []
        for lamp in lamps:
            kept = tuple(self._kept.get(lamp.sample.key, {}).values())
            # A received command replaces a pending one only after it has been authenticated.
            for packet in dict.fromkeys((*kept, *lamp.heard)):
                verdict = self._judged(stamp, lamp, packet)
                if verdict is not None:
                    verdicts.append(verdict)
        return verdicts

    def _judged(self, stamp: float, lamp: ReadLamp, packet: CommandPacket) -> Verdict | None:
        """Return the decision on a command if it is new, and keep the command if it may be accepted later."""
        key, operation = lamp.sample.key, packet.command.operation
        answer = self._authorizer.judge(packet, lamp.beacon, stamp)
        kept = self._kept.setdefault(key, {})
        if self._may_hold_later(lamp, packet, answer):
            kept[operation] = packet
        elif kept.get(operation) == packet:
            del kept[operation]
        if isinstance(answer, Accepted):
            self._told.pop((key, operation), None)
            return Verdict(packet, lamp.beacon, answer)
        # Do not report a repeated rule that was executed already.
        if answer.reason in (self._told.get((key, operation)), Refusal.DONE):
            return None
        self._told[key, operation] = answer.reason
        return Verdict(packet, lamp.beacon, answer)

    def _may_hold_later(self, lamp: ReadLamp, packet: CommandPacket, answer: Accepted | Refused) -> bool:
        # One-shot commands are repeated by the sender; a delayed one must not be executed.
        if packet.command.is_one_shot:
            return False
        if isinstance(answer, Accepted) or answer.reason in _WAITING:
            return True
        if answer.reason in _PASSING:
            # The rejection is independent of the command: keep one that is pending already.
            return self._kept[lamp.sample.key].get(packet.command.operation) == packet
        return answer.reason is Refusal.OTHER_BEACON and lamp.beacon is None
