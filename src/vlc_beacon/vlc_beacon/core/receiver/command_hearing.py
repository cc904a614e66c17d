"""Commands from lamps to the judge, and again when the robot has come nearer.

A rule takes seconds to be read, mostly on the way to its zone: the last ones of each lamp are kept and judged with
each image, so that they are obeyed as soon as the robot is where they hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vlc_beacon.core.packet.command_packet import CommandPacket
from vlc_beacon.core.receiver.light_receiver import ReadLamp
from vlc_beacon.core.trust.command_judge import CommandJudge
from vlc_beacon.core.trust.verdict import Accepted, Refusal, Refused

_WAITING = (Refusal.NO_POSITION, Refusal.OTHER_PLACE, Refusal.DONE)
"""Of rules that may hold later."""
_PASSING = (Refusal.LOCKED, Refusal.COUNTERS_LOST)
"""Of all commands, whatever they are."""


@dataclass(frozen=True)
class Verdict:
    """What became of a command.

    Attributes:
        packet: the command.
        speaker: ID of the lamp that spoke it, None while that is not confirmed.
        answer: of the judge.
    """

    packet: CommandPacket
    speaker: int | None
    answer: Accepted | Refused


class CommandHearing:
    """Brings the commands of all lamps before the judge."""

    def __init__(self, judge: CommandJudge) -> None:
        """Begin without commands.

        Args:
            judge: decides.
        """
        self._judge = judge
        self._kept: dict[int, dict[int, CommandPacket]] = {}
        self._told: dict[tuple[int, int], Refusal] = {}

    def hear(self, stamp: float, lamps: Sequence[ReadLamp]) -> list[Verdict]:
        """Return the verdicts that are new: acceptances, and refusals whose reason has changed.

        Args:
            stamp: of the image [s].
            lamps: in it.
        """
        keys = {lamp.sample.key for lamp in lamps}
        self._kept = {key: kept for key, kept in self._kept.items() if key in keys}
        self._told = {place: reason for place, reason in self._told.items() if place[0] in keys}
        verdicts = []
        for lamp in lamps:
            kept = tuple(self._kept.get(lamp.sample.key, {}).values())
            # What is heard does not replace what is kept before the judge has said that it is true.
            for packet in dict.fromkeys((*kept, *lamp.heard)):
                verdict = self._judged(stamp, lamp, packet)
                if verdict is not None:
                    verdicts.append(verdict)
        return verdicts

    def _judged(self, stamp: float, lamp: ReadLamp, packet: CommandPacket) -> Verdict | None:
        """Return the verdict on a command if it is new, and keep the command if it may be obeyed later."""
        key, operation = lamp.sample.key, packet.command.operation
        answer = self._judge.judge(packet, lamp.beacon, stamp)
        kept = self._kept.setdefault(key, {})
        if self._may_hold_later(lamp, packet, answer):
            kept[operation] = packet
        elif kept.get(operation) == packet:
            del kept[operation]
        if isinstance(answer, Accepted):
            self._told.pop((key, operation), None)
            return Verdict(packet, lamp.beacon, answer)
        # That a rule was done already is no news, whoever tells it again and again.
        if answer.reason in (self._told.get((key, operation)), Refusal.DONE):
            return None
        self._told[key, operation] = answer.reason
        return Verdict(packet, lamp.beacon, answer)

    def _may_hold_later(self, lamp: ReadLamp, packet: CommandPacket, answer: Accepted | Refused) -> bool:
        # Whoever streams one-shot commands says them again; an old one must not come true late.
        if packet.command.is_one_shot:
            return False
        if isinstance(answer, Accepted) or answer.reason in _WAITING:
            return True
        if answer.reason in _PASSING:
            # It says nothing of the command: one that was true before stays.
            return self._kept[lamp.sample.key].get(packet.command.operation) == packet
        return answer.reason is Refusal.OTHER_BEACON and lamp.beacon is None
