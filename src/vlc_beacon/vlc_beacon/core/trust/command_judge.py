"""Decides which commands a robot obeys.

The lamps are in everybody's reach: who can shine at a robot can show it anything, among it what a true lamp said before
or elsewhere. So a command must be signed, new, spoken by the very lamp that it names and near that lamp's place, and
what it asks for is bounded. Every packet has gone through a checksum before; a wrong signature is no accident.

What remains: who records a one-shot command that the robot has not heard can speak it to the robot later, at the same
place, until the robot hears a newer one of that beacon. A rule that is in force is done again when the robot is
switched on within its zone.
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
    """Judges the commands that one robot hears.

    Args:
        key: None refuses all commands.
        store: of the counters; what it cannot read or keep is refused.
        places: position x, y of each beacon in the map [m].
        settings: what is believed.
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
        self._standing = Refused(
            Refusal.NO_KEY, 'commands are refused: there is no key; set the parameter key_file'
        )
        if key is not None:
            self._read_counters()

    @property
    def standing_refusal(self) -> Refused | None:
        """Why all commands are refused until the robot's owner does something about it, or None."""
        return self._standing if self._key is None or self._counters is None else None

    def forget_place(self) -> None:
        """Forget where the robot is and its visits, after a jump back in time; the counters stay."""
        self._visits = ZoneVisits(self._places, self._settings.zone_radius)
        self._position: tuple[float, tuple[float, float]] | None = None

    def robot_at(self, stamp: float, position: tuple[float, float]) -> None:
        """Take the robot's position x, y in the map [m]; to be called with every pose [s]."""
        self._position = stamp, position
        self._visits.robot_at(position)

    def judge(self, packet: CommandPacket, speaker: int | None, stamp: float) -> Accepted | Refused:
        """Return what becomes of a command; one that is accepted is kept as seen before.

        A zone rule that was refused for its place may be judged again when the robot has come nearer.

        Args:
            packet: with a right checksum.
            speaker: confirmed ID of the lamp that it came from, None for none.
            stamp: of now [s].
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
            return Refused(Refusal.LOCKED, f'commands are refused for {wait:g} s after too many wrong codes')
        if not key.is_authentic(packet):
            self._lockout.add_bad(stamp)
            return Refused(Refusal.BAD_MAC, f'command of beacon {beacon} has a wrong code of authentication')
        if speaker != beacon:
            heard = 'a lamp whose ID is not confirmed' if speaker is None else f'beacon {speaker}'
            return Refused(Refusal.OTHER_BEACON, f'command of beacon {beacon} was spoken by {heard}')
        return None

    def _doubt_place(self, command: Command, stamp: float) -> Refused | None:
        beacon, settings = command.beacon, self._settings
        if self._position is None or abs(stamp - self._position[0]) > settings.position_age_max:
            return Refused(
                Refusal.NO_POSITION, f'command of beacon {beacon}: the robot does not know where it is'
            )
        distance = self._visits.distance(beacon, self._position[1])
        if distance is None:
            return Refused(
                Refusal.UNKNOWN_BEACON, f'command of beacon {beacon}, which is not in the beacons file'
            )
        if not self._visits.is_within(distance):
            return Refused(
                Refusal.OTHER_PLACE,
                f'command of beacon {beacon} {distance:.1f} m from its place (zone_radius {settings.zone_radius:g} m)',
            )
        return None

    def _doubt_novelty(self, command: Command, counters: Counters) -> Refused | None:
        named = f'command of beacon {command.beacon} with counter {command.counter}'
        last = counters.last(command)
        if command.is_one_shot and command.counter == last:
            return Refused(Refusal.REPEATED, f'{named} was heard before')
        if not counters.is_new(command):
            return Refused(Refusal.OLD_COUNTER, f'{named} is old: {last} was heard before')
        if not command.is_one_shot and self._visits.is_done(command):
            return Refused(Refusal.DONE, f'{named} was done on this visit')
        return None

    def _read_counters(self) -> None:
        try:
            self._counters = self._store.read()
        except VlcBeaconError as error:
            self._standing = Refused(Refusal.COUNTERS_LOST, f'commands are refused: {error}')

    def _keep(self, command: Command, counters: Counters) -> Refused | None:
        """Keep the counter before anything is done: what cannot be kept could be replayed after a restart."""
        after = counters.after(command)
        if after != counters:
            try:
                self._store.write(after)
            except VlcBeaconError as error:
                return Refused(Refusal.COUNTERS_LOST, f'commands are refused: {error}')
            self._counters = after
        if not command.is_one_shot:
            self._visits.add_done(command)
        return None


def _doubt_sense(command: Command) -> Refused | None:
    flaw = implausibility(command)
    if flaw is None:
        return None
    return Refused(Refusal.IMPLAUSIBLE, f'command of beacon {command.beacon}: {flaw}')
