"""Small rendered rooms with modulated lamps: the four lamps of the paper, seen from about their middle."""

from dataclasses import replace

from scene_simulator.ceiling.camera import UPWARD_MOUNT, CeilingCamera
from scene_simulator.ceiling.lamp import CeilingLamp, Disc
from scene_simulator.ceiling.lamp_drive import PAPER_LAMPS, LampDrive, paper_room
from scene_simulator.imaging.exposure import CameraClock
from scene_simulator.robot.leg_drive import LegDrive
from shirube_core.geometry import CameraMount, PinholeCamera
from shirube_core.waveform import steady_light
from vlc_beacon.core.packet.data_packet import IdPacket
from vlc_beacon.core.pose.lamp_rays import Beacon

CAMERA = PinholeCamera(300, 280, 318.2, 318.2, 149.5, 139.5)
MOUNT = CameraMount((0.0, 0.0, 0.2), UPWARD_MOUNT.rpy)
HEIGHT = 0.2
"""The lamps hang as far above this mount as above the paper's."""
PLACES = [(x, y, z + HEIGHT) for x, y, z in PAPER_LAMPS]
BEACONS = [Beacon(i + 1, place, 0.0325) for i, place in enumerate(PLACES)]
STRANGE_PLACE = (0.5, 0.75, 2.5 + HEIGHT)


def id_packets(count=4):
    """Return the ID packets of beacons 1 to ``count``."""
    return [IdPacket(i + 1).to_bytes() for i in range(count)]


def speaking_room(waveforms, shutter, rate):
    """Return a slow drive under four lamps that play waveforms, and a fifth that shines steadily."""
    eye = CeilingCamera(CAMERA, shutter)
    brightness = eye.brightness_for(0.9)
    room = paper_room(waveforms, Disc(0.065), brightness)
    lamps = tuple(
        replace(lamp, xyz=place, phase=0.1234 * i, clock_offset=20.0 * i - 30.0)
        for i, (lamp, place) in enumerate(zip(room.lamps, PLACES, strict=True))
    )
    steady = CeilingLamp(STRANGE_PLACE, Disc(0.065), steady_light(1), 0.8 * brightness)
    route = LegDrive([(0.82, 0.95), (0.98, 0.95)], [0.02], 0.1, rest=0.3)
    return LampDrive(replace(room, lamps=(*lamps, steady)), route, eye, MOUNT, clock=CameraClock(rate), seed=1)


def receptions(receiver, drive, seconds):
    """Yield frames and what a receiver makes of them that is given the wheels' odometry and the true tilt."""
    wheels = iter(drive.odometry(seconds))
    for frame in drive.frames(seconds):
        receiver.add_tilt(frame.stamp, *drive.tilt_at(frame.stamp))
        for reading in wheels:
            receiver.add_odometry(reading.time, reading.pose)
            if reading.time >= frame.stamp:
                break
        yield frame, receiver.receive(frame.stamp, frame.photo.image, CAMERA)


def write_messages(bag, stamp_ns, messages):
    """Write messages by their topics at a time."""
    for topic, message in messages.items():
        bag.write(topic, message.__msgtype__, message, stamp_ns)
