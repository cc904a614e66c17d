"""Result of the authorization of a command."""

import json
from dataclasses import dataclass
from enum import Enum

from vlc_beacon.core.packet.command_packet import Command, Operation


class RejectionReason(Enum):
    """Reason why a command is rejected."""

    NO_KEY = 'no key'
    LOCKED_OUT = 'locked out after wrong authentication codes'
    BAD_MAC = 'wrong authentication code'
    COUNTERS_LOST = 'counters lost'
    UNKNOWN_BEACON = 'unknown beacon'
    WRONG_BEACON = 'sent by another beacon'
    NO_POSITION = 'no position'
    WRONG_LOCATION = 'outside the zone of the beacon'
    OLD_COUNTER = 'old counter'
    REPLAYED = 'replayed'
    ALREADY_EXECUTED = 'executed on this visit'
    IMPLAUSIBLE = 'implausible'

    @property
    def is_suspicious(self) -> bool:
        """Whether the rejection may indicate an attack."""
        return self in (
            RejectionReason.LOCKED_OUT,
            RejectionReason.BAD_MAC,
            RejectionReason.UNKNOWN_BEACON,
            RejectionReason.WRONG_BEACON,
            RejectionReason.OLD_COUNTER,
        )


@dataclass(frozen=True)
class Rejected:
    """A rejected command with the reason, and one line with details."""

    reason: RejectionReason
    message: str


@dataclass(frozen=True)
class Accepted:
    """An accepted command, with its speed limited."""

    command: Command

    def to_json(self) -> str:
        """Return the JSON of the topic ``~/command``: beacon, counter, op and value."""
        fields = {
            'beacon': self.command.beacon,
            'counter': self.command.counter,
            'op': Operation(self.command.operation).label,
            'value': self.command.value,
        }
        return json.dumps(fields)
