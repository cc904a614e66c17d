"""Which commands are new.

Every command has a counter that its beacon's later commands do not fall below. A zone rule may be played for years, so
the last counter counts as new for it; a one-shot command must be above. Both kinds are counted apart: a one-shot
command must not make the lamp's own rules look old. All rules of one lamp carry the same counter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from vlc_beacon.core.packet.command_packet import Command


@dataclass(frozen=True)
class Counters:
    """The last counters seen.

    Attributes:
        floor: stands for the last counter of beacons that were not heard yet.
        zone_rules: last counter by beacon ID.
        one_shots: last counter by beacon ID.
    """

    floor: int = 0
    zone_rules: Mapping[int, int] = field(default_factory=dict)
    one_shots: Mapping[int, int] = field(default_factory=dict)

    def last(self, command: Command) -> int:
        """Return the last counter of the command's beacon and kind."""
        seen = self.one_shots if command.is_one_shot else self.zone_rules
        return seen.get(command.beacon, self.floor)

    def is_new(self, command: Command) -> bool:
        """Return whether a command is no replay."""
        return command.counter >= self.last(command) + command.is_one_shot

    def after(self, command: Command) -> Counters:
        """Return the counters after a new command."""
        if command.is_one_shot:
            return replace(self, one_shots={**self.one_shots, command.beacon: command.counter})
        return replace(self, zone_rules={**self.zone_rules, command.beacon: command.counter})


class CounterStore(Protocol):
    """Where counters outlive the robot's power switch."""

    def read(self) -> Counters:
        """Return the counters.

        Raises:
            VlcBeaconError: they are lost.
        """

    def write(self, counters: Counters) -> None:
        """Keep the counters.

        Raises:
            VlcBeaconError: they could not be kept.
        """
