"""Replay protection with command counters.

Counters of a beacon's commands never decrease. A zone rule may be sent for years, so the last counter is accepted again
for it; a one-shot command must have a higher one. Both kinds are counted separately: a one-shot command must not
invalidate the lamp's rules. All rules of one lamp have the same counter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from vlc_beacon.core.packet.command_packet import Command


@dataclass(frozen=True)
class Counters:
    """The last accepted counters.

    Attributes:
        floor: initial last counter of all beacons.
        zone_rules: last counter of zone rules by beacon ID.
        one_shots: last counter of one-shot commands by beacon ID.
    """

    floor: int = 0
    zone_rules: Mapping[int, int] = field(default_factory=dict)
    one_shots: Mapping[int, int] = field(default_factory=dict)

    def last_counter(self, command: Command) -> int:
        """Return the last counter of the command's beacon and kind."""
        seen = self.one_shots if command.is_one_shot else self.zone_rules
        return seen.get(command.beacon, self.floor)

    def is_new(self, command: Command) -> bool:
        """Return whether a command is not a replay."""
        return command.counter >= self.last_counter(command) + command.is_one_shot

    def advance(self, command: Command) -> Counters:
        """Return the counters after an accepted command."""
        if command.is_one_shot:
            return replace(self, one_shots={**self.one_shots, command.beacon: command.counter})
        return replace(self, zone_rules={**self.zone_rules, command.beacon: command.counter})


class CounterStore(Protocol):
    """Persistent storage of counters."""

    def read(self) -> Counters:
        """Return the counters; raises `VlcBeaconError` if they cannot be read."""

    def write(self, counters: Counters) -> None:
        """Store the counters; raises `VlcBeaconError` if they cannot be stored."""
