"""Pose tracking: several lamps give a pose, one lamp and odometry track it, odometry alone bridges gaps."""

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2, CameraMount, gravity_aligned_camera
from vlc_beacon.core.pose.beacon_locator import EXPECTED_SIGMAS, BeaconLocator
from vlc_beacon.core.pose.lamp_rays import Beacon, LampRays
from vlc_beacon.core.pose.pose_filter import PoseFilter
from vlc_beacon.core.pose.pose_fix import AnomalyKind, BeaconAnomaly, BeaconFix, NoBeaconFix
from vlc_beacon.core.pose.pose_least_squares import PoseLeastSquares
from vlc_beacon.core.settings import OdometrySettings, PoseSettings

KEYFRAMES_MAX = 12
KEYFRAME_SPACING = 0.1
"""Minimum distance between keyframes [m]."""
DISTANCE_MAX = 3.0
"""Maximum distance to a used keyframe [m]."""
DISTANCE_ERROR = 0.025
"""Odometry error between keyframes as a fraction of the distance."""
LAMP_HEIGHT = 2.0
"""Typical height of lamps above the camera [m], to convert the odometry error to a ray error."""


class KeyframeBuffer:
    """Recent lamp observations with their odometry poses."""

    def __init__(self) -> None:
        self._keyframes: deque[tuple[SE2, LampRays]] = deque(maxlen=KEYFRAMES_MAX)

    def clear(self) -> None:
        """Drop all keyframes."""
        self._keyframes.clear()

    def add(self, T_odom_base: SE2, rays: LampRays) -> None:
        """Add the lamps of an image as a keyframe, if there are any and the robot has moved."""
        if len(rays) and (not self._keyframes or self._keyframes[-1][0].distance_to(T_odom_base) >= KEYFRAME_SPACING):
            self._keyframes.append((T_odom_base, rays))

    def merged_with(self, T_odom_base: SE2, rays: LampRays) -> LampRays:
        """Return the lamps in view merged with those of earlier keyframes."""
        parts = [rays]
        for view, (T_odom_then, observed) in enumerate(self._keyframes, start=1):
            motion = T_odom_base.inverse() @ T_odom_then
            distance = math.hypot(motion.x, motion.y)
            if KEYFRAME_SPACING <= distance <= DISTANCE_MAX:
                parts.append(_transform_rays(observed, motion, distance, view))
        return LampRays(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(LampRays)))


def _transform_rays(observed: LampRays, motion: SE2, distance: float, view: int) -> LampRays:
    motions = [motion @ SE2(*row) for row in observed.motions.tolist()]
    pixel = np.sqrt(np.abs(np.linalg.det(observed.pixel_jacobians)))
    return replace(
        observed,
        sigmas=np.hypot(observed.sigmas, DISTANCE_ERROR * distance / LAMP_HEIGHT / pixel),
        motions=np.array([[each.x, each.y, each.yaw] for each in motions]),
        views=np.full(len(observed), view),
    )


LOST_IMAGES = 60
"""Number of images with two or more lamps, all of them outliers, after which the filter is reset."""


class BeaconTracker:
    """Tracks the robot's pose under lamps."""

    def __init__(
        self,
        beacons: Iterable[Beacon],
        mount: CameraMount,
        known_height: float | None = None,
        settings: PoseSettings | None = None,
        odometry_settings: OdometrySettings | None = None,
    ) -> None:
        """Start without a pose; arguments as in `BeaconLocator` and `PoseFilter`."""
        self._beacons, self._known_height = list(beacons), known_height
        self._filter: PoseFilter | None = None
        self.apply_settings(mount, settings or PoseSettings(), odometry_settings or OdometrySettings())
        self._T_odom_base: SE2 | None = None
        self._keyframes = KeyframeBuffer()
        self._lost_images = 0

    def apply_settings(self, mount: CameraMount, settings: PoseSettings, odometry: OdometrySettings) -> None:
        """Use another mount and other settings; the pose is kept."""
        self._mount, self._settings, self._odometry_settings = mount, settings, odometry
        self.locator = BeaconLocator(self._beacons, mount, self._known_height, settings)
        if self._filter is not None:
            self._filter.apply_settings(settings, odometry)

    def reset(self) -> None:
        """Reset the pose."""
        self._filter = None
        self._keyframes.clear()
        self._lost_images = 0

    def add_odometry(self, T_odom_base: SE2) -> None:
        """Add the newest odometry pose; call it before `track` for the same time."""
        if self._filter is not None and self._T_odom_base is not None:
            self._filter.predict(self._T_odom_base.inverse() @ T_odom_base)
        self._T_odom_base = T_odom_base

    def track(self, rays: LampRays, tilt: tuple[float, float] = (0.0, 0.0)) -> BeaconFix | NoBeaconFix:
        """Compute the pose at the newest odometry pose; arguments as in `BeaconLocator.locate`."""
        # A pose that is uncertain, or contradicted by lamps for long, is given up.
        if self._filter is not None and not (self._filter.is_certain and self._lost_images < LOST_IMAGES):
            self.reset()
        # The pose from this image alone; the prediction resolves ambiguities.
        expected = None if self._filter is None else self._filter.expected()
        result = self.locator.locate(rays, tilt, expected)
        # At the start: lamps that were seen one after the other.
        if self._filter is None and isinstance(result, NoBeaconFix):
            result = self._locate_from_keyframes(rays, tilt, result)
        # A pose from several lamps that contradicts the prediction replaces it.
        if isinstance(result, BeaconFix) and (
            expected is None
            or expected.mahalanobis_distance(result.T_map_base, result.planar_covariance) > EXPECTED_SIGMAS
        ):
            self.reset()
            self._filter = PoseFilter(
                result.T_map_base, result.height, result.covariance, self._settings, self._odometry_settings
            )
            return result
        # Otherwise the lamps, one is enough, update the prediction.
        return result if self._filter is None else self._update_filter(self._filter, rays, tilt, result)

    def _locate_from_keyframes(
        self, rays: LampRays, tilt: tuple[float, float], single_view_result: NoBeaconFix
    ) -> BeaconFix | NoBeaconFix:
        """Return the pose from the lamps in view and those of earlier keyframes."""
        if self._T_odom_base is None:
            return single_view_result
        merged = self._keyframes.merged_with(self._T_odom_base, rays)
        self._keyframes.add(self._T_odom_base, rays)
        result = self.locator.locate(merged, tilt) if len(merged) > len(rays) else single_view_result
        return result if isinstance(result, BeaconFix) and not result.anomalies else single_view_result

    def _update_filter(
        self, filter_: PoseFilter, rays: LampRays, tilt: tuple[float, float], result: BeaconFix | NoBeaconFix
    ) -> BeaconFix | NoBeaconFix:
        """Update the filter with the consistent lamps and return its pose."""
        camera = gravity_aligned_camera(self._mount, *tilt)
        lamps = np.array([self.locator.beacons[int(id_)].xyz for id_ in rays.ids]).reshape(-1, 3)
        candidates = result.used if isinstance(result, BeaconFix) else np.ones(len(rays), dtype=np.bool_)
        used = np.zeros(len(rays), dtype=np.bool_)
        if candidates.any():
            used[candidates] = filter_.update(rays.subset(candidates), lamps[candidates], camera)
        if used.any():
            self._lost_images = 0
        elif len(set(rays.ids.tolist())) > 1:
            self._lost_images += 1
        if isinstance(result, NoBeaconFix) and not filter_.is_confirmed:
            return result  # do not publish dead reckoning: a fusion of both would count odometry twice
        anomalies = result.anomalies if isinstance(result, BeaconFix) else _outlier_anomalies(rays, used)
        problem = PoseLeastSquares(rays, lamps, camera, None, self._settings)
        residuals = problem.evaluate(filter_.bearing_state).residuals
        pose, height, covariance = filter_.pose, filter_.height, filter_.covariance
        return BeaconFix(pose, height, covariance, (0.0, 0.0), used, residuals, anomalies)


def _outlier_anomalies(rays: LampRays, used: NDArray[np.bool_]) -> tuple[BeaconAnomaly, ...]:
    """Return the outliers of the filter; an outlier whose ID is also an inlier is a duplicate."""
    inlier_ids = set(rays.ids[used].tolist())
    return tuple(
        BeaconAnomaly(id_, i, AnomalyKind.DUPLICATED if id_ in inlier_ids else AnomalyKind.MOVED)
        for i, id_ in enumerate(rays.ids.tolist())
        if not used[i]
    )
