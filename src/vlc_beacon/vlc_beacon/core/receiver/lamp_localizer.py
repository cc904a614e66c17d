"""Robot pose from identified lamps, by the configured method."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2, CameraMount, PinholeCamera, gravity_aligned_camera
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.pose.beacon_tracker import BeaconTracker
from vlc_beacon.core.pose.known_states import KnownStates
from vlc_beacon.core.pose.lamp_rays import LampRays, row_motions
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix
from vlc_beacon.core.pose.radius_interval import LampDiscs, radius_interval, radius_interval_printed
from vlc_beacon.core.receiver.light_receiver import LampObservation
from vlc_beacon.core.receiver.settings import CENTROID, RADIUS_INTERVAL, ReceiverSettings

_RADIUS_MIN = 0.5
"""Minimum lamp radius after subtraction of the blooming [px]."""


class LampLocalizer:
    """Computes the robot's pose from the lamps in view.

    With odometry the pose is tracked with one lamp; without, each image is independent.
    """

    def __init__(self, beacons: Iterable[Beacon], mount: CameraMount, settings: ReceiverSettings) -> None:
        """Start without a pose.

        Args:
            beacons: lamps of the beacons file.
            mount: pose of the camera on the robot.
            settings: receiver settings with camera and method.
        """
        self._settings = settings
        self._mount = mount
        known = KnownStates(height=0.0 if settings.camera_height_known else None)
        self._tracker = BeaconTracker(beacons, mount, known, settings.pose, settings.odometry)

    def locate(
        self,
        lamps: Sequence[LampObservation],
        camera: PinholeCamera,
        T_odom_base: SE2 | None,
        velocity: NDArray[np.float64],
        tilt: tuple[float, float],
    ) -> BeaconFix | NoBeaconFix:
        """Compute the pose at the stamp of an image.

        Args:
            lamps: lamps in the image; only lit ones with an ID are used.
            camera: camera intrinsics.
            T_odom_base: odometry pose at the stamp, None if unavailable.
            velocity: velocity of the base, shape (3,) [m/s, m/s, rad/s].
            tilt: roll and pitch of the base [rad].
        """
        identified = [lamp for lamp in lamps if lamp.beacon is not None and lamp.sample.is_lit]
        rays = self._rays(identified, camera, velocity)
        if T_odom_base is None:
            self._tracker.reset()
            result = self._tracker.locator.locate(rays, tilt)
        else:
            self._tracker.add_odometry(T_odom_base)
            result = self._tracker.track(rays, tilt)
        if self._settings.method == CENTROID or isinstance(result, NoBeaconFix):
            return result
        return self._locate_by_radius(identified, camera, tilt, result)

    def _rays(
        self, identified: Sequence[LampObservation], camera: PinholeCamera, velocity: NDArray[np.float64]
    ) -> LampRays:
        centres = np.array([lamp.sample.centre for lamp in identified]).reshape(-1, 2)
        sigmas = np.array([lamp.sample.sigma.max() for lamp in identified])
        row_time = self._settings.row_time if self._settings.is_rolling else 0.0
        motions = row_motions(centres[:, 1], row_time, velocity)
        ids = [lamp.beacon for lamp in identified if lamp.beacon is not None]
        return self._tracker.locator.rays(camera, ids, centres, sigmas, motions)

    def _locate_by_radius(
        self,
        identified: Sequence[LampObservation],
        camera: PinholeCamera,
        tilt: tuple[float, float],
        result: BeaconFix,
    ) -> BeaconFix | NoBeaconFix:
        """Return the pose from the lamp radii; the paper's methods need the yaw, here from the centroids."""
        radii = np.array([lamp.sample.radius for lamp in identified]) - self._settings.blooming
        beacons = self._tracker.locator.beacons
        discs = LampDiscs(
            [beacons[lamp.beacon] for lamp in identified if lamp.beacon is not None],
            np.array([lamp.sample.centre for lamp in identified]).reshape(-1, 2),
            np.maximum(radii, _RADIUS_MIN),
            float(np.max([lamp.sample.sigma.max() for lamp in identified], initial=0.0)),
        )
        method = radius_interval if self._settings.method == RADIUS_INTERVAL else radius_interval_printed
        radius_fix = method(discs, camera, gravity_aligned_camera(self._mount, *tilt), result.T_map_base.yaw)
        if isinstance(radius_fix, NoBeaconFix):
            return radius_fix
        covariance = radius_fix.covariance.copy()
        covariance[3, 3] = result.covariance[3, 3]
        return replace(radius_fix, covariance=covariance, anomalies=result.anomalies)
