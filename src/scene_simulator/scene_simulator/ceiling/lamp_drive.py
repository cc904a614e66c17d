"""A robot's drive under ceiling lamps: what its camera, its wheels and its inertial unit record, and the truth."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from scene_simulator.ceiling.camera import UPWARD_MOUNT, CeilingCamera, CeilingPhoto
from scene_simulator.ceiling.lamp import CeilingLamp, Disc, LampShape, LedGrid, Rectangle
from scene_simulator.ceiling.room import CeilingRoom
from scene_simulator.errors import SceneError, check_seed
from scene_simulator.imaging.exposure import CameraClock, CameraPose, camera_pose
from scene_simulator.robot.leg_drive import LegDrive, Suspension, TiltErrors
from scene_simulator.robot.robot_drive import Route, SensorDrive, WheelErrors
from shirube_core.geometry import SE2, CameraMount
from shirube_core.waveform import Waveform, waveform_from_steps

GOOD_WHEEL_ERRORS = WheelErrors(left_scale=1.0195, right_scale=1.0205, slip=0.0002)
"""Good wheels: 2 % too much distance and rotation, and 0.2 degrees a metre to the left."""

FIRM_SUSPENSION = Suspension(heave=0.001, tilt=math.radians(1.0))
"""A body that heaves by a millimetre and tilts by up to a degree."""

_IMAGE_NOISE, _CLOCK = range(2)


@dataclass(frozen=True)
class LampFrame:
    """A frame of the camera and the truth about it.

    Attributes:
        stamp: stamp of the image [s].
        photo: image, true times and projections of the lamps.
        pose: ``T_map_base`` at the true start of the frame, of which the stamp is the reading.
    """

    stamp: float
    photo: CeilingPhoto
    pose: SE2


@dataclass(frozen=True)
class LampDrive(SensorDrive):
    """Everything that is recorded on a drive; the same seed gives the same recording.

    Attributes:
        room: ceiling and lights.
        route: the true drive, a ``LegDrive`` or a ``RobotDrive``.
        camera: looks up.
        mount: pose of the camera in ``base_link`` while the body is at rest.
        suspension: heave and tilt of the body.
        clock: rhythm of the camera.
        wheels: errors of the odometry.
        tilt: errors of the inertial unit.
        seed: seed of noise and errors; the suspension has a separate seed.
    """

    WHEEL_STREAM, TILT_STREAM = 2, 3
    room: CeilingRoom
    route: Route
    camera: CeilingCamera = field(default_factory=CeilingCamera)
    mount: CameraMount = UPWARD_MOUNT
    suspension: Suspension = FIRM_SUSPENSION
    clock: CameraClock = field(default_factory=CameraClock)
    wheels: WheelErrors = GOOD_WHEEL_ERRORS
    tilt: TiltErrors = field(default_factory=TiltErrors)
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse a negative seed with a SceneError."""
        check_seed(self.seed)

    def camera_pose_at(self, time: float) -> CameraPose:
        """Return ``T_map_camera`` at a time [s]."""
        return camera_pose(self.pose_at(time), self.suspension.mount_at(time, self.mount))

    def frame_count(self, seconds: float) -> int:
        """Return how many frames ``frames`` yields."""
        return len(self.clock.frames(seconds, self.rng(_CLOCK))[0])

    def frames(self, seconds: float) -> Iterator[LampFrame]:
        """Yield the frames of the first seconds one by one, or raise SceneError if the time is not positive."""
        starts, stamps = self.clock.frames(seconds, self.rng(_CLOCK))
        for index, (start, stamp) in enumerate(zip(starts.tolist(), stamps.tolist(), strict=True)):
            noise = self.rng(_IMAGE_NOISE, index)
            photo = self.camera.photograph(self.room, self.camera_pose_at, start, noise)
            yield LampFrame(stamp, photo, self.pose_at(start))


PAPER_LAMPS = ((0.0, 0.0, 2.5), (0.0, 1.8, 2.5), (1.8, 0.0, 2.5), (1.8, 1.8, 2.5))
"""Places of the paper's panels (3.1) in the map frame [m]."""

_STEPS = 64  # steps in which a period of the mains' flicker is played
LAMP_A, LAMP_B = 3, 2  # indices into ``PAPER_LAMPS``: A at (1.8, 1.8), B at (1.8, 0)
_OFFSET = 0.05  # lateral distance between the legs and the lamps [m]
_CORNER_RADIUS = 0.3


def paper_room(
    waveforms: Sequence[Waveform], shape: LampShape | None = None, brightness: float = 2000.0
) -> CeilingRoom:
    """Return the paper's room (3.1), dark, with four panels of 8 x 8 LEDs, or of another shape.

    Args:
        waveforms: what the four lamps send, in the order of ``PAPER_LAMPS``; a SceneError for any other number.
        shape: another shape for all four.
        brightness: brightness of the lamps, in full wells per second of exposure [1/s].
    """
    if len(waveforms) != len(PAPER_LAMPS):
        raise SceneError(f'the room of the paper has 4 lamps: give 4 waveforms, not {len(waveforms)}')
    face = shape or LedGrid()
    lamps = zip(PAPER_LAMPS, waveforms, strict=True)
    return CeilingRoom(tuple(CeilingLamp(xyz, face, waveform, brightness) for xyz, waveform in lamps))


def mains_flicker(frequency: float = 100.0, depth: float = 0.3) -> Waveform:
    """Return the light of a room lamp on the mains: a raised cosine, brightest in the middle of the period.

    It flickers at twice the mains frequency [Hz]; the depth is the fraction that is missing at the darkest.
    """
    middles = (np.arange(_STEPS) + 0.5) / _STEPS
    levels = 1.0 - depth * np.square(np.cos(np.pi * middles))
    return waveform_from_steps(np.full(_STEPS, 1.0 / (_STEPS * frequency)), levels)


def distractors(brightness: float = 2000.0) -> tuple[CeilingLamp, ...]:
    """Return lights without a code in the paper's room: a spot, a flickering tube and panel, a window.

    The brightness [1/s] is that of the spot; the others are dimmer.
    """
    mains = mains_flicker()
    window = (math.pi / 2.0, 0.0, 0.0)
    return (
        CeilingLamp((0.9, 2.6, 2.48), Disc(0.04), brightness=brightness),
        CeilingLamp((-0.8, 0.9, 2.45), Rectangle(0.03, 1.2), mains, 0.7 * brightness),
        CeilingLamp((2.9, 0.3, 2.5), Rectangle(0.3, 0.3), mains, 0.4 * brightness, phase=0.003),
        CeilingLamp((0.9, 3.9, 1.9), Rectangle(1.6, 1.0), brightness=0.6 * brightness, rpy=window),
    )


def paper_run(
    waveforms: Sequence[Waveform],
    speed: float = 0.25,
    slow_speed: float = 0.125,
    camera: CeilingCamera | None = None,
    seed: int = 0,
    rest: float = 3.0,
    shape: LampShape | None = None,
) -> LampDrive:
    """Return the run in the paper's dim room, with other lights about.

    With a rest of 3 s A is in view for the first 9 s before the robot reaches it: time for two command packets of
    30 bit/s.

    Args:
        waveforms: what the four lamps of ``PAPER_LAMPS`` send.
        speed: speed before A and after B [m/s].
        slow_speed: speed between A and B [m/s].
        camera: the camera, by default the paper's with a global shutter and 0.5 ms of exposure.
        seed: random seed.
        rest: pause at the start [s].
        shape: shape of the lamps, by default the paper's panels of 8 x 8 LEDs.

    Raises:
        SceneError: not four waveforms, or speeds that are not positive.
    """
    chosen = camera or CeilingCamera()
    brightness = chosen.brightness_for(1.0)
    room = paper_room(waveforms, shape, brightness).with_ambient_light(0.03 * brightness, seed=seed)
    a, b = PAPER_LAMPS[LAMP_A], PAPER_LAMPS[LAMP_B]
    x = a[0] - _OFFSET
    corners = [(-0.1, a[1] - _OFFSET), (x, a[1] - _OFFSET), (x, b[1] + _OFFSET), (-1.0, b[1] + _OFFSET)]
    route = LegDrive(corners, [speed, slow_speed, speed], _CORNER_RADIUS, rest)
    return LampDrive(room.with_lights(distractors(brightness)), route, chosen, seed=seed)
