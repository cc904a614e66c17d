"""Authorizes commands.

The optical channel is open: an attacker can send arbitrary packets, including recordings of a genuine lamp. A command
must therefore be signed, not replayed, sent by the lamp that it names and received near that lamp, and its value is
bounded. Every packet has passed a checksum before, so a wrong signature is not a transmission error.

Remaining risk: a recorded one-shot command that the robot has not received can be replayed later at the same location,
until the robot receives a newer one of that beacon. An active rule is executed again when the robot is switched on
within its zone.
"""

import json
import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from vlc_beacon.core.authorization.keys_and_counters import CommandKey, Counters, CounterStore
from vlc_beacon.core.packet.command_packet import Command, CommandPacket, Operation, clamp_speed, find_implausibility
from vlc_beacon.core.settings import AuthorizationSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


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


EXIT_FACTOR = 1.25
"""Exit radius over zone radius: hysteresis for a robot at the border."""


class Lockout:
    """Limits brute-force attacks: with 5 guesses per minute, a 32-bit code takes 800 years on average.

    It applies to all beacons together; otherwise an attacker could guess with each ID.

    Args:
        failures_max: authentication failures within ``time`` that trigger the lockout.
        time: window of the failures, and duration of the lockout [s].
    """

    def __init__(self, failures_max: int, time: float) -> None:
        self._failures: deque[float] = deque(maxlen=failures_max)
        self._time = time
        self._locked_at: float | None = None

    def is_locked(self, stamp: float) -> bool:
        """Return whether commands are rejected at a time [s]. A clock that is set back ends the lockout."""
        return self._locked_at is not None and 0.0 <= stamp - self._locked_at < self._time

    def add_failure(self, stamp: float) -> None:
        """Add an authentication failure [s]."""
        self._failures.append(stamp)
        if len(self._failures) == self._failures.maxlen and 0.0 <= stamp - self._failures[0] < self._time:
            self._locked_at = stamp
            self._failures.clear()


class ZoneVisits:
    """Zone rules executed on the current visit of each zone.

    Args:
        positions: position x, y of each beacon in the map [m].
        radius: radius of the zones [m].
    """

    def __init__(self, positions: Mapping[int, tuple[float, float]], radius: float) -> None:
        self._positions = dict(positions)
        self.radius = radius
        self._executed: dict[int, set[tuple[int, int]]] = {}

    def update_position(self, position: tuple[float, float]) -> None:
        """Update the robot's position [m] and end the visits of zones that it left."""
        for beacon in list(self._executed):
            if not math.dist(position, self._positions[beacon]) <= EXIT_FACTOR * self.radius:
                del self._executed[beacon]

    def is_executed(self, command: Command) -> bool:
        """Return whether the rule was executed on this visit."""
        return (command.counter, command.operation) in self._executed.get(command.beacon, set())

    def mark_executed(self, command: Command) -> None:
        """Mark the rule as executed."""
        self._executed.setdefault(command.beacon, set()).add((command.counter, command.operation))


class CommandAuthorizer:
    """Authorizes the commands received by one robot.

    Args:
        key: key of the commands; None rejects all commands.
        store: persistent counters; commands are rejected if it cannot be read or written.
        positions: position x, y of each beacon in the map [m].
        settings: authorization settings.

    Attributes:
        permanent_rejection: rejection of all commands that requires action by the user, or None.
    """

    def __init__(
        self,
        key: CommandKey | None,
        store: CounterStore,
        positions: Mapping[int, tuple[float, float]],
        settings: AuthorizationSettings,
    ) -> None:
        self._key = key
        self._store = store
        self._settings = settings
        self._positions = dict(positions)
        self._lockout = Lockout(settings.bad_macs_max, settings.lockout_time)
        self.reset_position()
        self._counters = Counters()
        self.permanent_rejection: Rejected | None = None
        if key is None:
            message = 'commands are rejected: no key; set the parameter key_file'
            self.permanent_rejection = Rejected(RejectionReason.NO_KEY, message)
            return
        try:
            self._counters = store.read()
        except VlcBeaconError as error:
            self.permanent_rejection = _counters_lost(error)

    def apply_settings(self, settings: AuthorizationSettings) -> None:
        """Use other settings; counters, lockout and visits are kept."""
        self._settings = settings
        self._visits.radius = settings.zone_radius

    def reset_position(self) -> None:
        """Reset the robot's position and visits after a jump back in time; the counters are kept."""
        self._visits = ZoneVisits(self._positions, self._settings.zone_radius)
        self._position: tuple[float, tuple[float, float]] | None = None

    def update_position(self, stamp: float, position: tuple[float, float]) -> None:
        """Update the robot's position x, y in the map [m]; call it with every pose [s]."""
        self._position = stamp, position
        self._visits.update_position(position)

    def authorize(self, packet: CommandPacket, sender: int | None, stamp: float) -> Accepted | Rejected:
        """Authorize a command; the counter of an accepted command is stored.

        A zone rule that was rejected for its location can be authorized again when the robot is nearer.

        Args:
            packet: command packet with a correct checksum.
            sender: confirmed ID of the sending lamp, None if unconfirmed.
            stamp: current time [s].
        """
        if self.permanent_rejection is not None:
            return self.permanent_rejection
        command = packet.command
        return (
            self._check_sender(packet, sender, stamp)
            or self._check_location(command, stamp)
            or self._check_replay(command)
            or _check_plausibility(command)
            or self._store_counter(command)
            or Accepted(clamp_speed(command, self._settings.speed_limit))
        )

    def _check_sender(self, packet: CommandPacket, sender: int | None, stamp: float) -> Rejected | None:
        beacon = packet.command.beacon
        if self._lockout.is_locked(stamp):
            wait = self._settings.lockout_time
            message = f'commands are rejected for {wait:g} s after too many wrong authentication codes'
            return Rejected(RejectionReason.LOCKED_OUT, message)
        if self._key is None or not self._key.is_authentic(packet):
            self._lockout.add_failure(stamp)
            message = f'command of beacon {beacon} has a wrong authentication code'
            return Rejected(RejectionReason.BAD_MAC, message)
        if sender != beacon:
            source = 'a lamp with an unconfirmed ID' if sender is None else f'beacon {sender}'
            return Rejected(RejectionReason.WRONG_BEACON, f'command of beacon {beacon} was sent by {source}')
        return None

    def _check_location(self, command: Command, stamp: float) -> Rejected | None:
        name, settings = f'command of beacon {command.beacon}', self._settings
        if self._position is None or abs(stamp - self._position[0]) > settings.position_age_max:
            return Rejected(RejectionReason.NO_POSITION, f'{name}: the robot has no current position')
        if command.beacon not in self._positions:
            return Rejected(RejectionReason.UNKNOWN_BEACON, f'{name}, which is not in the beacons file')
        distance = math.dist(self._position[1], self._positions[command.beacon])
        if not distance <= settings.zone_radius:
            message = f'{name} at {distance:.1f} m from it (zone_radius {settings.zone_radius:g} m)'
            return Rejected(RejectionReason.WRONG_LOCATION, message)
        return None

    def _check_replay(self, command: Command) -> Rejected | None:
        description = f'command of beacon {command.beacon} with counter {command.counter}'
        last_counter = self._counters.last_counter(command)
        if command.is_one_shot and command.counter == last_counter:
            return Rejected(RejectionReason.REPLAYED, f'{description} was received before')
        if not self._counters.is_new(command):
            message = f'{description} is old: the last counter is {last_counter}'
            return Rejected(RejectionReason.OLD_COUNTER, message)
        if not command.is_one_shot and self._visits.is_executed(command):
            return Rejected(RejectionReason.ALREADY_EXECUTED, f'{description} was executed on this visit')
        return None

    def _store_counter(self, command: Command) -> Rejected | None:
        """Store the counter before execution; otherwise the command could be replayed after a restart."""
        advance = self._counters.advance(command)
        if advance != self._counters:
            try:
                self._store.write(advance)
            except VlcBeaconError as error:
                return _counters_lost(error)
            self._counters = advance
        if not command.is_one_shot:
            self._visits.mark_executed(command)
        return None


def _counters_lost(error: VlcBeaconError) -> Rejected:
    return Rejected(RejectionReason.COUNTERS_LOST, f'commands are rejected: {error}')


def _check_plausibility(command: Command) -> Rejected | None:
    flaw = find_implausibility(command)
    message = f'command of beacon {command.beacon}: {flaw}'
    return None if flaw is None else Rejected(RejectionReason.IMPLAUSIBLE, message)
