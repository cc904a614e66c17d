"""Films of the room whose four lamps speak, as a camera on a slow robot takes them, and the receiver for them."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from scene_simulator.ceiling.camera import PAPER_OPTICS, UPWARD_MOUNT, CeilingCamera
from scene_simulator.ceiling.lamp import Disc, LampShape, LedGrid
from scene_simulator.ceiling.lamp_drive import PAPER_LAMPS, LampDrive, LampFrame, distractors, paper_room
from scene_simulator.ceiling.room import Person
from scene_simulator.imaging.exposure import CameraClock, Shutter
from scene_simulator.robot.leg_drive import LegDrive
from shirube_core.waveform import Waveform
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.authorization.keys_and_counters import CommandKey, Counters
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.packet.command_packet import Command, Operation
from vlc_beacon.core.packet.data_packet import IdPacket
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings

BEACONS = tuple(Beacon(k + 1, xyz, LedGrid.radius) for k, xyz in enumerate(PAPER_LAMPS))
COMMANDING = 4  # the beacon that says a command, too
KEY = CommandKey(bytes(range(32)))
LEVEL = 0.9  # of a lamp in the image, 1 is 255


@dataclass(frozen=True)
class Channel:
    """Light code, shutter and images a second."""

    name: str
    rate: float
    shutter: Shutter
    shape: LampShape
    encode: Callable[[list[bytes]], Waveform]

    @property
    def settings(self) -> ReceiverSettings:
        """Settings of the receiver."""
        row_time = self.shutter.row_time
        kind, rows = ('rolling', row_time) if row_time else ('global', ReceiverSettings().row_time)
        return ReceiverSettings(kind, rows, self.shutter.exposure, self.rate)


UFSOOK = Channel('UFSOOK, panels, global shutter', 60.0, Shutter(), LedGrid(), ufsook_waveform)
RS_FSK_30, RS_FSK_60 = (
    Channel(
        f'RS-FSK, discs, rolling shutter, {rate:.0f} images/s',
        rate,
        Shutter(60e-6, row_time),
        Disc(LedGrid.radius),
        partial(rs_fsk_waveform, frame_rate=rate),
    )
    for rate, row_time in ((30.0, 18.9e-6), (60.0, 15e-6))
)


@dataclass(frozen=True)
class Film:
    """How a film is taken.

    Attributes:
        name: name in the table.
        channel: lamps and camera.
        ambient: light of the ceiling over that of the lamps.
        people: how many people walk or stand about the room.
    """

    name: str
    channel: Channel
    ambient: float
    people: int = 0


FILMS = (
    Film('global, UFSOOK, panels, dim room', UFSOOK, 0.03),
    Film('global, UFSOOK, panels, lit room', UFSOOK, 0.3),
    Film('rolling, RS-FSK, discs, dim room', RS_FSK_30, 0.03),
    Film('rolling, RS-FSK, discs, lit room', RS_FSK_30, 0.3),
    Film('rolling, RS-FSK, panels, lit room', replace(RS_FSK_30, shape=UFSOOK.shape), 0.3),
    Film('global, UFSOOK, panels, lit room, 5 people', UFSOOK, 0.3, 5),
    Film('global, UFSOOK, panels, lit room, 15 people', UFSOOK, 0.3, 15),
    Film('rolling, RS-FSK, discs, lit room, 15 people', RS_FSK_30, 0.3, 15),
)
"""Panels are the paper's 8 x 8 LEDs, discs the same lamps behind frosted glass."""


class CounterMemory:
    """Keeps the counters of commands while a film runs."""

    def __init__(self) -> None:
        """Begin with no counter received."""
        self._counters = Counters()

    def read(self) -> Counters:
        """Return the counters."""
        return self._counters

    def write(self, counters: Counters) -> None:
        """Keep the counters."""
        self._counters = counters


def random_people(count: int, seed: int) -> tuple[Person, ...]:
    """Return people in the paper's room of 7 x 6 m, every third standing; heads are about 1.3 m above the camera."""
    rng, people = np.random.default_rng(seed), []
    for index in range(count):
        start, end = 0.9 + rng.uniform((-3.3, -2.8), (3.3, 2.8), (2, 2))
        top, speed = 1.3 + rng.uniform(-0.2, 0.2), 0.0 if index % 3 == 2 else rng.uniform(0.6, 1.5)
        people.append(Person((start[0], start[1]), (end[0], end[1]), top, speed))
    return tuple(people)


def encode_packets(beacon: int) -> list[bytes]:
    """Return what a lamp plays in turn: its ID twice, and one of them a command."""
    packets = [IdPacket(beacon).to_bytes()] * 2
    if beacon == COMMANDING:
        packets.append(KEY.sign(Command(beacon, Operation.SLOW, 0.125, 1)).to_bytes())
    return packets


def simulate_drive(film: Film) -> LampDrive:
    """Return a slow drive in the middle of the room, other lights about."""
    channel, eye = film.channel, CeilingCamera(PAPER_OPTICS, film.channel.shutter)
    brightness = eye.brightness_for(LEVEL)
    waveforms = [channel.encode(encode_packets(beacon.id)) for beacon in BEACONS]
    room = paper_room(waveforms, channel.shape, brightness).with_ambient_light(film.ambient * brightness)
    # Lamps are switched on one by one and their clocks are not those of the camera.
    lamps = tuple(replace(lamp, phase=0.1234 * k, clock_offset=20.0 * k - 30.0) for k, lamp in enumerate(room.lamps))
    room = replace(room, lamps=lamps, people=random_people(film.people, 1)).with_lights(distractors(brightness))
    route = LegDrive([(0.7, 0.9), (1.1, 0.9)], [0.04], 0.1)
    return LampDrive(room, route, eye, UPWARD_MOUNT, clock=CameraClock(channel.rate), seed=1)


def receiver_for(channel: Channel, authorization: AuthorizationSettings) -> BeaconReceiver:
    """Return a receiver that knows the lamps and the key."""
    places = {beacon.id: beacon.xyz[:2] for beacon in BEACONS}
    authorizer = CommandAuthorizer(KEY, CounterMemory(), places, authorization)
    return BeaconReceiver(BEACONS, UPWARD_MOUNT, authorizer, channel.settings)


def receive_frames(drive: LampDrive, receiver: BeaconReceiver, seconds: float) -> Iterator[LampFrame]:
    """Yield the frames of a drive; the receiver gets the wheel and IMU data that precede each."""
    wheels, tilts = deque(drive.odometry(seconds)), deque(drive.tilt_readings(seconds, 0.01))
    for frame in drive.frames(seconds):
        while wheels and wheels[0].time <= frame.stamp:
            wheel = wheels.popleft()
            receiver.add_odometry(wheel.time, wheel.pose)
        while tilts and tilts[0].time <= frame.stamp:
            tilt = tilts.popleft()
            receiver.add_tilt(tilt.time, tilt.roll, tilt.pitch)
        yield frame
