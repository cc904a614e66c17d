"""The complete receiver: images, odometry and tilt in; lamps, pose and commands out."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2, CameraMount, PinholeCamera, TiltBuffer, gravity_aligned_camera
from shirube_core.motion import NoPoseReason, OdometryBuffer
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.lamp_image.blooming import fit_lit_lamp
from vlc_beacon.core.pose.beacon_tracker import BeaconTracker
from vlc_beacon.core.pose.lamp_rays import Beacon, row_motions
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix
from vlc_beacon.core.pose.radius_interval import LampDiscs, radius_interval, radius_interval_printed
from vlc_beacon.core.receiver.command_processor import CommandDecision, CommandProcessor
from vlc_beacon.core.receiver.light_receiver import LampMessage, LampObservation, LightReceiver
from vlc_beacon.core.receiver.pose_consistency import PoseConsistencyCheck
from vlc_beacon.core.settings import CENTROID, RADIUS_INTERVAL, ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


class LampOdometry:
    """Recent odometry by time in seconds."""

    def __init__(self) -> None:
        self._buffer = OdometryBuffer()

    def add(self, stamp: float, T_odom_base: SE2) -> None:
        """Add a pose at a time [s], in any order."""
        self._buffer.add(round(1e9 * stamp), T_odom_base)

    def pose_at(self, stamp: float) -> SE2 | None:
        """Return ``T_odom_base`` at a time [s], interpolated or shortly extrapolated; None if no pose is near."""
        pose = self._buffer.pose_at(round(1e9 * stamp))
        return None if isinstance(pose, NoPoseReason) else pose

    def velocity_at(self, stamp: float) -> NDArray[np.float64]:
        """Return the velocity of the base along its x and y [m/s] and its yaw rate [rad/s]; zeros if unknown."""
        return np.array(self._buffer.twist_at(round(1e9 * stamp)))

    def has_jumped(self, start: float, end: float) -> bool:
        """Return whether the odometry jumped between two times [s]."""
        return self._buffer.motion(round(1e9 * start), round(1e9 * end)) is NoPoseReason.JUMPED


_UP_MIN = 0.5
"""Minimum cosine of the angle between the optical axis and the vertical."""
_RADIUS_MIN = 0.5
"""Minimum lamp radius after subtraction of the blooming [px]."""


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

    @property
    def messages(self) -> list[LampMessage]:
        """Messages completed by this image."""
        return [LampMessage(lamp.beacon, lamp.message) for lamp in self.lamps if lamp.message is not None]


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
        check_looks_up(mount)
        known, settings = list(beacons), settings or ReceiverSettings()
        self._authorizer = authorizer
        self._light = LightReceiver(known, settings)
        self._localizer = LampLocalizer(known, mount, settings)
        self._command_processor = CommandProcessor(authorizer)
        self._odometry, self._tilt = LampOdometry(), TiltBuffer()
        self._pose_check = PoseConsistencyCheck()
        self._last_image: tuple[float, SE2 | None] | None = None

    def apply_settings(self, mount: CameraMount, settings: ReceiverSettings) -> None:
        """Use another mount and other settings from the next image on; tracked lamps and the pose are kept.

        The pose is found anew after a change of the mount. Errors are those of the constructor.
        """
        check_looks_up(mount)
        self._light.apply_settings(settings)
        self._localizer.apply_settings(mount, settings)

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
            camera: camera intrinsics, K of eq. (2).

        Raises:
            LampImageError: the image has a wrong type or is too small.
        """
        grey = image if image.ndim == 2 else np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)
        # Motion and tilt of the robot at the exposure; the tilt is the attitude of eq. (1).
        T_odom_base, velocity = self._odometry.pose_at(stamp), self._odometry.velocity_at(stamp)
        tilt = self._tilt.tilt_at(stamp) or (0.0, 0.0)
        motion = self._motion_since_last_image(stamp, T_odom_base)
        # Section 2.1: find the light sources, follow them and demodulate IDs, data and commands.
        # The image turns opposite to the robot.
        lamps = self._light.receive(stamp, grey, 0.0 if motion is None else -motion.yaw)
        # Section 2.2: the pose from the places of the identified lamps in the image.
        result = self._localizer.locate(lamps, camera, T_odom_base, velocity, tilt, grey)
        # Spoofed lamps cannot displace the odometry: only consistent poses locate commands.
        if isinstance(result, BeaconFix):
            pose = result.T_map_base
            if self._pose_check.is_consistent(stamp, pose, T_odom_base):
                self._authorizer.update_position(stamp, (pose.x, pose.y))
        # Section 3.3: authorize the commands, also those that wait for the robot to enter their zone.
        decisions = self._command_processor.process(stamp, lamps)
        return ReceiverOutput(tuple(lamps), result, tuple(decisions))

    def _motion_since_last_image(self, stamp: float, T_odom_base: SE2 | None) -> SE2 | None:
        """Return the motion of the base since the last image; None without odometry and when it jumped.

        After a jump, poses before and after it have no common odometry frame.
        """
        last, self._last_image = self._last_image, (stamp, T_odom_base)
        if last is None or last[1] is None or T_odom_base is None:
            return None
        if self._odometry.has_jumped(last[0], stamp):
            self._localizer.reset()
            self._pose_check.drop_odometry()
            return None
        return last[1].inverse() @ T_odom_base


def check_looks_up(mount: CameraMount) -> None:
    """Raise a VlcBeaconError for a camera that does not look up."""
    if mount.rotation[2, 2] < _UP_MIN:
        raise VlcBeaconError(f'camera_rpy is {list(mount.rpy)}: the camera does not look up; [0, 0, 1.5708] does')


class LampLocalizer:
    """Computes the robot's pose from the lamps in view, by the configured method.

    With odometry the pose is tracked with one lamp; without, each image is independent.
    """

    def __init__(self, beacons: Iterable[Beacon], mount: CameraMount, settings: ReceiverSettings) -> None:
        """Start without a pose; arguments as in `BeaconReceiver`."""
        self._settings = settings
        self._mount = mount
        known_height = 0.0 if settings.camera_height_known else None
        self._tracker = BeaconTracker(beacons, mount, known_height, settings.pose, settings.odometry)

    def apply_settings(self, mount: CameraMount, settings: ReceiverSettings) -> None:
        """Use another mount, which resets the tracked pose, and other settings."""
        if mount != self._mount:
            self.reset()
        self._settings, self._mount = settings, mount
        self._tracker.apply_settings(mount, settings.pose, settings.odometry)

    def reset(self) -> None:
        """Reset the tracked pose."""
        self._tracker.reset()

    def locate(
        self,
        lamps: Sequence[LampObservation],
        camera: PinholeCamera,
        T_odom_base: SE2 | None,
        velocity: NDArray[np.float64],
        tilt: tuple[float, float],
        image: NDArray[np.uint8] | None = None,
    ) -> BeaconFix | NoBeaconFix:
        """Compute the pose at the stamp of an image.

        Args:
            lamps: lamps in the image; only lit ones with an ID are used.
            camera: camera intrinsics.
            T_odom_base: odometry pose at the stamp, None if unavailable.
            velocity: velocity of the base, shape (3,) [m/s, m/s, rad/s].
            tilt: roll and pitch of the base [rad].
            image: grey image, shape (h, w), in which eq. (4) is fitted; None to use the thresholded radii.
        """
        # Rays to the identified lamps; the rows of a rolling shutter are exposed one after the other.
        identified = [lamp for lamp in lamps if lamp.beacon is not None and lamp.sample.is_lit]
        ids = [lamp.beacon for lamp in identified if lamp.beacon is not None]
        centres = np.array([lamp.sample.centre for lamp in identified]).reshape(-1, 2)
        sigmas = np.array([lamp.sample.sigma.max() for lamp in identified])
        row_time = self._settings.row_time if self._settings.is_rolling else 0.0
        motions = row_motions(centres[:, 1], row_time, velocity)
        rays = self._tracker.locator.rays(camera, ids, centres, sigmas, motions)
        # Method centroid: least squares on the lamp centres, tracked with odometry.
        if T_odom_base is None:
            self.reset()
            result = self._tracker.locator.locate(rays, tilt)
        else:
            self._tracker.add_odometry(T_odom_base)
            result = self._tracker.track(rays, tilt)
        if self._settings.method == CENTROID or isinstance(result, NoBeaconFix):
            return result
        # The paper's method: eqs (3) to (7) on the lamp radii; it needs the yaw, here from the centroids.
        discs = LampDiscs(
            [self._tracker.locator.beacons[id_] for id_ in ids],
            centres,
            self._radii(identified, image),
            float(np.max(sigmas, initial=0.0)),
        )
        method = radius_interval if self._settings.method == RADIUS_INTERVAL else radius_interval_printed
        radius_fix = method(discs, camera, gravity_aligned_camera(self._mount, *tilt), result.T_map_base.yaw)
        if isinstance(radius_fix, NoBeaconFix):
            return radius_fix
        covariance = radius_fix.covariance.copy()
        covariance[3, 3] = result.covariance[3, 3]
        return replace(radius_fix, covariance=covariance, anomalies=result.anomalies)

    def _radii(self, lamps: Sequence[LampObservation], image: NDArray[np.uint8] | None) -> NDArray[np.float64]:
        """Return the radii of lamps in the image without blooming, shape (n,) [px].

        Eq. (4) gives the radius at any exposure; the threshold does where it cannot be fitted, and in the bands of a
        rolling shutter.
        """
        image = None if self._settings.is_rolling else image
        fits = [None if image is None else fit_lit_lamp(image, lamp.sample) for lamp in lamps]
        bloomed = [
            lamp.sample.radius if fit is None else fit.half_maximum_radius
            for lamp, fit in zip(lamps, fits, strict=True)
        ]
        return np.maximum(np.array(bloomed) - self._settings.blooming, _RADIUS_MIN)
