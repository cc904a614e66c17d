"""Authorizes commands.

The optical channel is open: an attacker can send arbitrary packets, including recordings of a genuine lamp. A command
must therefore be signed, not replayed, sent by the lamp that it names and received near that lamp, and its value is
bounded. Every packet has passed a checksum before, so a wrong signature is not a transmission error.

Remaining risk: a recorded one-shot command that the robot has not received can be replayed later at the same location,
until the robot receives a newer one of that beacon. An active rule is executed again when the robot is switched on
within its zone.
"""

from __future__ import annotations

from collections.abc import Mapping

from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.trust.command_key import CommandKey
from vlc_beacon.core.trust.counters import Counters, CounterStore
from vlc_beacon.core.trust.lockout import Lockout
from vlc_beacon.core.trust.plausibility import implausibility, within_speed_limit
from vlc_beacon.core.trust.trust_settings import TrustSettings
from vlc_beacon.core.trust.verdict import Accepted, Refusal, Refused
from vlc_beacon.core.trust.zone_visits import ZoneVisits
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


class CommandJudge:
    """Authorizes the commands received by one robot.

    Args:
        key: key of the commands; None rejects all commands.
        store: persistent counters; commands are rejected if it cannot be read or written.
        places: position x, y of each beacon in the map [m].
        settings: authorization settings.
    """

    def __init__(
        self,
        key: CommandKey | None,
        store: CounterStore,
        places: Mapping[int, tuple[float, float]],
        settings: TrustSettings,
    ) -> None:
        self._key = key
        self._store = store
        self._settings = settings
        self._places = places
        self._lockout = Lockout(settings.bad_macs_max, settings.lockout_time)
        self.forget_place()
        self._counters: Counters | None = None
        self._standing = Refused(Refusal.NO_KEY, 'commands are rejected: no key; set the parameter key_file')
        if key is not None:
            self._read_counters()

    @property
    def standing_refusal(self) -> Refused | None:
        """Rejection of all commands that requires action by the user, or None."""
        return self._standing if self._key is None or self._counters is None else None

    def forget_place(self) -> None:
        """Reset the robot's position and visits after a jump back in time; the counters are kept."""
        self._visits = ZoneVisits(self._places, self._settings.zone_radius)
        self._position: tuple[float, tuple[float, float]] | None = None

    def robot_at(self, stamp: float, position: tuple[float, float]) -> None:
        """Update the robot's position x, y in the map [m]; call it with every pose [s]."""
        self._position = stamp, position
        self._visits.robot_at(position)

    def judge(self, packet: CommandPacket, speaker: int | None, stamp: float) -> Accepted | Refused:
        """Accept or reject a command; the counter of an accepted command is stored.

        A zone rule that was rejected for its location can be authorized again when the robot is nearer.

        Args:
            packet: command packet with a correct checksum.
            speaker: confirmed ID of the sending lamp, None if unconfirmed.
            stamp: current time [s].
        """
        if self._key is None or self._counters is None:
            return self._standing
        command = packet.command
        return (
            self._doubt_sender(packet, self._key, speaker, stamp)
            or self._doubt_place(command, stamp)
            or self._doubt_novelty(command, self._counters)
            or _doubt_sense(command)
            or self._keep(command, self._counters)
            or Accepted(within_speed_limit(command, self._settings.speed_limit))
        )

    def _doubt_sender(
        self, packet: CommandPacket, key: CommandKey, speaker: int | None, stamp: float
    ) -> Refused | None:
        beacon = packet.command.beacon
        if self._lockout.is_closed(stamp):
            wait = self._settings.lockout_time
            return Refused(
                Refusal.LOCKED,
                f'commands are rejected for {wait:g} s after too many wrong authentication codes',
            )
        if not key.is_authentic(packet):
            self._lockout.add_bad(stamp)
            return Refused(Refusal.BAD_MAC, f'command of beacon {beacon} has a wrong authentication code')
        if speaker != beacon:
            heard = 'a lamp with an unconfirmed ID' if speaker is None else f'beacon {speaker}'
            return Refused(Refusal.OTHER_BEACON, f'command of beacon {beacon} was sent by {heard}')
        return None

    def _doubt_place(self, command: Command, stamp: float) -> Refused | None:
        beacon, settings = command.beacon, self._settings
        if self._position is None or abs(stamp - self._position[0]) > settings.position_age_max:
            return Refused(
                Refusal.NO_POSITION, f'command of beacon {beacon}: the robot has no current position'
            )
        distance = self._visits.distance(beacon, self._position[1])
        if distance is None:
            return Refused(
                Refusal.UNKNOWN_BEACON, f'command of beacon {beacon}, which is not in the beacons file'
            )
        if not self._visits.is_within(distance):
            return Refused(
                Refusal.OTHER_PLACE,
                f'command of beacon {beacon} at {distance:.1f} m from it (zone_radius {settings.zone_radius:g} m)',
            )
        return None

    def _doubt_novelty(self, command: Command, counters: Counters) -> Refused | None:
        named = f'command of beacon {command.beacon} with counter {command.counter}'
        last = counters.last(command)
        if command.is_one_shot and command.counter == last:
            return Refused(Refusal.REPEATED, f'{named} was received before')
        if not counters.is_new(command):
            return Refused(Refusal.OLD_COUNTER, f'{named} is old: the last counter is {last}')
        if not command.is_one_shot and self._visits.is_done(command):
            return Refused(Refusal.DONE, f'{named} was executed on this visit')
        return None

    def _read_counters(self) -> None:
        try:
            self._counters = self._store.read()
        except VlcBeaconError as error:
            self._standing = Refused(Refusal.COUNTERS_LOST, f'commands are rejected: {error}')

    def _keep(self, command: Command, counters: Counters) -> Refused | None:
        """Store the counter before execution; otherwise the command could be replayed after a restart."""
        after = counters.after(command)
        if after != counters:
            try:
                self._store.write(after)
            except VlcBeaconError as error:
                return Refused(Refusal.COUNTERS_LOST, f'commands are rejected: {error}')
            self._counters = after
        if not command.is_one_shot:
            self._visits.add_done(command)
        return None


def _doubt_sense(command: Command) -> Refused | None:
    flaw = implausibility(command)
    if flaw is None:
        return None
    return Refused(Refusal.IMPLAUSIBLE, f'command of beacon {command.beacon}: {flaw}')
