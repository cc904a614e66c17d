"""The complete receiver: images, odometry and tilt in; lamps, pose and commands out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_geometry import CameraMount, PinholeCamera, PlanarPose, TiltTrail
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix
from vlc_beacon.core.receiver.command_hearing import CommandHearing, Verdict
from vlc_beacon.core.receiver.lamp_localizer import LampLocalizer
from vlc_beacon.core.receiver.light_receiver import LightReceiver, ReadLamp
from vlc_beacon.core.receiver.odometry_trail import OdometryTrail
from vlc_beacon.core.receiver.settings import ReceiverSettings
from vlc_beacon.core.receiver.trusted_place import TrustedPlace
from vlc_beacon.core.trust.command_judge import CommandJudge
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

_UP_MIN = 0.5
"""Minimum cosine of the angle between the optical axis and the vertical."""


@dataclass(frozen=True)
class Reception:
    """Output of the receiver for one image.

    Attributes:
        lamps: tracked lamps.
        result: pose, or the reason for none.
        verdicts: decisions on received commands.
    """

    lamps: tuple[ReadLamp, ...]
    result: BeaconFix | NoBeaconFix
    verdicts: tuple[Verdict, ...]


class BeaconReceiver:
    """Combines decoding, localization and command authorization."""

    def __init__(
        self,
        beacons: Iterable[Beacon],
        mount: CameraMount,
        judge: CommandJudge,
        settings: ReceiverSettings | None = None,
    ) -> None:
        """Start without lamps.

        Args:
            beacons: lamps of the beacons file, each ID once.
            mount: pose of the upward camera on the robot.
            judge: authorizer of commands; it survives resets of the receiver.
            settings: receiver settings, None for the defaults.

        Raises:
            VlcBeaconError: the camera does not look up, or the tones of the lamps are not separable.
        """
        if mount.rotation[2, 2] < _UP_MIN:
            raise VlcBeaconError(
                f'camera_rpy is {list(mount.rpy)}: the camera does not look up; [0, 0, 1.5708] does'
            )
        known, settings = list(beacons), settings or ReceiverSettings()
        self._judge = judge
        self._light = LightReceiver(known, settings)
        self._localizer = LampLocalizer(known, mount, settings)
        self._hearing = CommandHearing(judge)
        self._odometry, self._tilt = OdometryTrail(), TiltTrail()
        self._place = TrustedPlace()
        self._last_odometry: PlanarPose | None = None

    def add_odometry(self, stamp: float, T_odom_base: PlanarPose) -> None:
        """Add an odometry pose at a time [s]."""
        self._odometry.add(stamp, T_odom_base)

    def add_tilt(self, stamp: float, roll: float, pitch: float) -> None:
        """Add fixed-axis roll and pitch of the base [rad] at a time [s]."""
        self._tilt.add(stamp, roll, pitch)

    def receive(self, stamp: float, image: NDArray[np.uint8], camera: PinholeCamera) -> Reception:
        """Process an image.

        Args:
            stamp: start of exposure of the first row [s].
            image: grey image, shape (h, w), or BGR image, shape (h, w, 3).
            camera: camera intrinsics.

        Raises:
            LampImageError: the image has a wrong type or is too small.
        """
        grey = image if image.ndim == 2 else np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)
        odometry = self._odometry.pose_at(stamp)
        lamps = self._light.receive(stamp, grey, self._image_turn(odometry))
        tilt = self._tilt.tilt_at(stamp) or (0.0, 0.0)
        velocity = self._odometry.velocity_at(stamp)
        result = self._localizer.locate(lamps, camera, odometry, velocity, tilt)
        if isinstance(result, BeaconFix) and self._place.is_believed(stamp, result.T_map_base, odometry):
            self._judge.robot_at(stamp, (result.T_map_base.x, result.T_map_base.y))
        return Reception(tuple(lamps), result, tuple(self._hearing.hear(stamp, lamps)))

    def _image_turn(self, odometry: PlanarPose | None) -> float:
        """Return the image rotation since the last image [rad], opposite to the robot's rotation."""
        before, self._last_odometry = self._last_odometry, odometry
        return -before.turn_to(odometry) if before is not None and odometry is not None else 0.0
