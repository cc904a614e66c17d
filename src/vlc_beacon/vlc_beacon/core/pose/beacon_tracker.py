"""Pose tracking: several lamps give a pose, one lamp and odometry track it, odometry alone bridges gaps."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import CameraMount, PlanarPose, level_camera
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.pose.beacon_locator import EXPECTED_SIGMAS, BeaconLocator
from vlc_beacon.core.pose.joined_views import JoinedViews
from vlc_beacon.core.pose.known_states import KnownStates
from vlc_beacon.core.pose.lamp_rays import LampRays
from vlc_beacon.core.pose.odometry_settings import OdometrySettings
from vlc_beacon.core.pose.pose_filter import PoseFilter
from vlc_beacon.core.pose.pose_fix import BeaconDoubt, BeaconFix, DoubtKind, NoBeaconFix
from vlc_beacon.core.pose.pose_least_squares import PoseLeastSquares
from vlc_beacon.core.pose.settings import PoseSettings

LOST_IMAGES = 60
"""Number of images with two or more lamps, all of them outliers, after which the filter is reset."""


class BeaconTracker:
    """Tracks the robot's pose under lamps."""

    def __init__(
        self,
        beacons: Iterable[Beacon],
        mount: CameraMount,
        known: KnownStates | None = None,
        settings: PoseSettings | None = None,
        odometry_settings: OdometrySettings | None = None,
    ) -> None:
        """Start without a pose.

        Args:
            beacons: known lamps, each ID once.
            mount: pose of the camera on the robot.
            known: known components of the pose, None for none.
            settings: measurement noise, None for the defaults.
            odometry_settings: odometry noise, None for the defaults.
        """
        self._settings = settings or PoseSettings()
        self._odometry_settings = odometry_settings or OdometrySettings()
        self.locator = BeaconLocator(beacons, mount, known, self._settings)
        self._mount = mount
        self._filter: PoseFilter | None = None
        self._T_odom_base: PlanarPose | None = None
        self._views = JoinedViews()
        self._lost_images = 0

    def forget(self) -> None:
        """Reset the pose."""
        self._filter = None
        self._views.clear()
        self._lost_images = 0

    def add_odometry(self, T_odom_base: PlanarPose) -> None:
        """Add the newest odometry pose; call it before `track` for the same time."""
        if self._filter is not None and self._T_odom_base is not None:
            self._filter.move(self._T_odom_base.inverse() @ T_odom_base)
        self._T_odom_base = T_odom_base

    def track(self, rays: LampRays, tilt: tuple[float, float] = (0.0, 0.0)) -> BeaconFix | NoBeaconFix:
        """Compute the pose at the time of the newest odometry pose.

        Args:
            rays: rays to known lamps from `BeaconLocator.rays`, possibly none.
            tilt: roll and pitch of the robot [rad].
        """
        if self._filter is not None and not (self._filter.is_certain and self._lost_images < LOST_IMAGES):
            self.forget()
        expected = None if self._filter is None else self._filter.expected()
        found = self.locator.locate(rays, tilt, expected)
        if self._filter is None and isinstance(found, NoBeaconFix):
            found = self._joined(rays, tilt, found)
        if isinstance(found, BeaconFix) and (
            expected is None
            or expected.distance_of(found.T_map_base, found.planar_covariance) > EXPECTED_SIGMAS
        ):
            self._start(found)
            return found
        return found if self._filter is None else self._filtered(self._filter, rays, tilt, found)

    def _joined(
        self, rays: LampRays, tilt: tuple[float, float], alone: NoBeaconFix
    ) -> BeaconFix | NoBeaconFix:
        """Return the pose from the lamps in view and those of earlier keyframes."""
        if self._T_odom_base is None:
            return alone
        joined = self._views.seen_from(self._T_odom_base, rays)
        self._views.add(self._T_odom_base, rays)
        found = self.locator.locate(joined, tilt) if len(joined) > len(rays) else alone
        return found if isinstance(found, BeaconFix) and not found.doubts else alone

    def _start(self, found: BeaconFix) -> None:
        self._filter = PoseFilter(
            found.T_map_base, found.height, found.covariance, self._settings, self._odometry_settings
        )
        self._views.clear()
        self._lost_images = 0

    def _filtered(
        self,
        filter_: PoseFilter,
        rays: LampRays,
        tilt: tuple[float, float],
        found: BeaconFix | NoBeaconFix,
    ) -> BeaconFix | NoBeaconFix:
        """Update the filter with the consistent lamps and return its pose."""
        camera = level_camera(self._mount, *tilt)
        lamps = np.array([self.locator.beacons[int(id_)].xyz for id_ in rays.ids]).reshape(-1, 3)
        wanted = found.used if isinstance(found, BeaconFix) else np.ones(len(rays), dtype=np.bool_)
        used = np.zeros(len(rays), dtype=np.bool_)
        if wanted.any():
            used[wanted] = filter_.add_lamps(rays.subset(wanted), lamps[wanted], camera)
        if used.any():
            self._lost_images = 0
        elif len(set(rays.ids.tolist())) > 1:
            self._lost_images += 1
        if isinstance(found, NoBeaconFix) and not filter_.is_confirmed:
            return found  # do not publish dead reckoning: a fusion of both would count odometry twice
        doubts = found.doubts if isinstance(found, BeaconFix) else _unfitting(rays, used)
        squares = PoseLeastSquares(rays, lamps, camera, KnownStates(), self._settings)
        residuals = squares.evaluate(filter_.bearing_state).residuals
        return BeaconFix(
            filter_.pose, filter_.height, filter_.covariance, (0.0, 0.0), used, residuals, doubts
        )


def _unfitting(rays: LampRays, used: NDArray[np.bool_]) -> tuple[BeaconDoubt, ...]:
    """Return the outliers of the filter; an outlier whose ID is also an inlier is a duplicate."""
    own_ids = set(rays.ids[used].tolist())
    return tuple(
        BeaconDoubt(
            int(rays.ids[i]), int(i), DoubtKind.COPIED if int(rays.ids[i]) in own_ids else DoubtKind.MOVED
        )
        for i in np.flatnonzero(~used)
    )
