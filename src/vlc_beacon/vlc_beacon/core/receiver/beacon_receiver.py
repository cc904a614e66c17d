"""The complete receiver: images, odometry and tilt in; lamps, pose and commands out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2, CameraMount, PinholeCamera, TiltBuffer
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix
from vlc_beacon.core.receiver.command_processor import CommandDecision, CommandProcessor
from vlc_beacon.core.receiver.lamp_localizer import LampLocalizer
from vlc_beacon.core.receiver.light_receiver import LampObservation, LightReceiver
from vlc_beacon.core.receiver.odometry_buffer import OdometryBuffer
from vlc_beacon.core.receiver.pose_consistency import PoseConsistencyCheck
from vlc_beacon.core.receiver.settings import ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

_UP_MIN = 0.5
"""Minimum cosine of the angle between the optical axis and the vertical."""


@dataclass(frozen=True)
class ReceiverOutput:
    """Output of the receiver for one image.

    Attributes:
        lamps: tracked lamps.
        result: pose, or the reason for none.
        decisions: decisions on received commands.
    """

    lamps: tuple[LampObservation, ...]
    result: BeaconFix | NoBeaconFix
    decisions: tuple[CommandDecision, ...]


class BeaconReceiver:
    """Combines decoding, localization and command authorization."""

    def __init__(
        self,
        beacons: Iterable[Beacon],
        mount: CameraMount,
        authorizer: CommandAuthorizer,
        settings: ReceiverSettings | None = None,
    ) -> None:
        """Start without lamps.

        Args:
            beacons: lamps of the beacons file, each ID once.
            mount: pose of the upward camera on the robot.
            authorizer: authorizer of commands; it survives resets of the receiver.
            settings: receiver settings, None for the defaults.

        Raises:
            VlcBeaconError: the camera does not look up, or the tones of the lamps are not separable.
        """
        if mount.rotation[2, 2] < _UP_MIN:
            raise VlcBeaconError(
                f'camera_rpy is {list(mount.rpy)}: the camera does not look up; [0, 0, 1.5708] does'
            )
        known, settings = list(beacons), settings or ReceiverSettings()
        self._authorizer = authorizer
        self._light = LightReceiver(known, settings)
        self._localizer = LampLocalizer(known, mount, settings)
        self._command_processor = CommandProcessor(authorizer)
        self._odometry, self._tilt = OdometryBuffer(), TiltBuffer()
        self._pose_check = PoseConsistencyCheck()
        self._last_odometry: SE2 | None = None

    def add_odometry(self, stamp: float, T_odom_base: SE2) -> None:
        """Add an odometry pose at a time [s]."""
        self._odometry.add(stamp, T_odom_base)

    def add_tilt(self, stamp: float, roll: float, pitch: float) -> None:
        """Add fixed-axis roll and pitch of the base [rad] at a time [s]."""
        self._tilt.add(stamp, roll, pitch)

    def receive(self, stamp: float, image: NDArray[np.uint8], camera: PinholeCamera) -> ReceiverOutput:
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
        lamps = self._light.receive(stamp, grey, self._image_rotation(odometry))
        tilt = self._tilt.tilt_at(stamp) or (0.0, 0.0)
        velocity = self._odometry.velocity_at(stamp)
        result = self._localizer.locate(lamps, camera, odometry, velocity, tilt)
        if isinstance(result, BeaconFix) and self._pose_check.is_consistent(
            stamp, result.T_map_base, odometry
        ):
            self._authorizer.update_position(stamp, (result.T_map_base.x, result.T_map_base.y))
        return ReceiverOutput(tuple(lamps), result, tuple(self._command_processor.process(stamp, lamps)))

    def _image_rotation(self, odometry: SE2 | None) -> float:
        """Return the image rotation since the last image [rad], opposite to the robot's rotation."""
        before, self._last_odometry = self._last_odometry, odometry
        return -before.yaw_to(odometry) if before is not None and odometry is not None else 0.0
