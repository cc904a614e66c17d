"""What becomes of a command."""

from __future__ import annotations

import json
from dataclasses import dataclass
from enum import Enum

from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.core.packet.operation import Operation


class Refusal(Enum):
    """Why a command is refused."""

    NO_KEY = 'no key'
    LOCKED = 'locked after wrong codes of authentication'
    BAD_MAC = 'wrong code of authentication'
    COUNTERS_LOST = 'counters lost'
    UNKNOWN_BEACON = 'unknown beacon'
    OTHER_BEACON = 'spoken by another beacon'
    NO_POSITION = 'no position'
    OTHER_PLACE = 'spoken at another place'
    OLD_COUNTER = 'old counter'
    REPEATED = 'repeated'
    DONE = 'done on this visit'
    IMPLAUSIBLE = 'implausible'

    @property
    def is_suspicious(self) -> bool:
        """Whether somebody may be at work who should not; the rest is daily life."""
        return self in (
            Refusal.LOCKED,
            Refusal.BAD_MAC,
            Refusal.UNKNOWN_BEACON,
            Refusal.OTHER_BEACON,
            Refusal.OLD_COUNTER,
        )


@dataclass(frozen=True)
class Refused:
    """A command that is not obeyed.

    Attributes:
        reason: of the refusal.
        message: one line with the numbers.
    """

    reason: Refusal
    message: str


@dataclass(frozen=True)
class Accepted:
    """A command to obey.

    Attributes:
        command: with a speed that is within the limit.
    """

    command: Command

    def to_json(self) -> str:
        """Return what the topic ``~/command`` carries: beacon, counter, op and value."""
        fields = {
            'beacon': self.command.beacon,
            'counter': self.command.counter,
            'op': Operation(self.command.operation).word,
            'value': self.command.value,
        }
        return json.dumps(fields)
