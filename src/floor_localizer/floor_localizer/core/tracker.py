"""Tracking over time: poses predicted from odometry or velocity are priors; sparse views are merged by odometry."""

import math
from collections import deque
from dataclasses import replace

import numpy as np

from floor_localizer.core.arrays import Floats, Pixels
from floor_localizer.core.dots import DetectedDots, FloorPoints, merge_points, transform_points
from floor_localizer.core.fix import Fix, NoFix, NoFixReason, PosePrior
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import TrackerSettings
from shirube_core.geometry import SE2, PinholeCamera
from shirube_core.motion import NoPoseReason, OdometryBuffer


class PosePredictor:
    """Buffers odometry and the last two poses, and predicts the next pose; ``settings`` are its tolerances."""

    def __init__(self, settings: TrackerSettings) -> None:
        """Start with empty buffers.

        Args:
            settings: tolerances of the prediction.
        """
        self.settings = settings
        self._odometry = OdometryBuffer()
        self._poses: deque[tuple[float, SE2]] = deque(maxlen=2)

    def add_odometry(self, stamp: float, T_odom_base: SE2) -> None:
        """Add an odometry pose, in any order; a stamp that is there already is ignored."""
        self._odometry.add(round(1e9 * stamp), T_odom_base)

    def add_pose(self, stamp: float, T_map_base: SE2) -> None:
        """Add a pose that was found."""
        self._poses.append((stamp, T_map_base))

    def clear_poses(self) -> None:
        """Clear the poses, but not the odometry."""
        self._poses.clear()

    def relative_motion(self, earlier: float, later: float) -> SE2 | None:
        """Return the pose at ``later`` in the base frame at ``earlier`` from odometry, None if unknown."""
        motion = self._odometry.motion(round(1e9 * earlier), round(1e9 * later))
        return None if isinstance(motion, NoPoseReason) else motion

    def predict(self, stamp: float) -> PosePrior | None:
        """Predict the pose at a time; None if unknown or too uncertain to be useful."""
        if not self._poses or stamp < self._poses[-1][0]:
            return None
        last_stamp, last = self._poses[-1]
        step = self.relative_motion(last_stamp, stamp)
        prior = self._predict_from_velocity(stamp) if step is None else self._predict_from_odometry(last, step)
        return prior if prior.radius <= self.settings.prior_radius_max else None

    def _predict_from_odometry(self, last: SE2, step: SE2) -> PosePrior:
        settings = self.settings
        distance = math.hypot(step.x, step.y)
        error = settings.odometry_error
        return PosePrior(
            last @ step,
            settings.still_radius + error * distance,
            min(settings.still_turn + error * (distance + abs(step.yaw)), math.pi),
        )

    def _predict_from_velocity(self, stamp: float) -> PosePrior:
        """Predict with the velocity between the last two poses; the tolerances cover the maximum acceleration."""
        settings = self.settings
        last_stamp, last = self._poses[-1]
        dt = stamp - last_stamp
        first_stamp, first = self._poses[0]
        interval = last_stamp - first_stamp
        step = SE2(0.0, 0.0, 0.0)
        if interval > 0.0:
            step = SE2.exp(*(dt / interval * v for v in (first.inverse() @ last).log()))
        squared_time = dt * (dt + interval) if interval > 0.0 else dt * max(dt, 0.3)
        return PosePrior(
            last @ step,
            settings.still_radius + settings.acceleration_max * squared_time,
            min(settings.still_turn + settings.turn_acceleration_max * squared_time, math.pi),
        )


# Radius of the search area of an initial pose [standard deviations].
_AREA_SIGMAS = 3.0


class FloorTracker:
    """Tracks a robot from image to image."""

    def __init__(self, localizer: FloorLocalizer, settings: TrackerSettings | None = None) -> None:
        """Start without a prior.

        Args:
            localizer: finds the pose from one image.
            settings: settings of prediction and search, None for the defaults.
        """
        self._localizer = localizer
        self._settings = settings or TrackerSettings()
        self._predictor = PosePredictor(self._settings)
        self._area: PosePrior | None = None
        self._area_stamp = math.nan  # of the first view after the area was set
        self._unlocated_views: deque[tuple[float, FloorPoints]] = deque(maxlen=self._settings.joined_views - 1)
        self._last_thorough = -math.inf

    def apply_settings(self, localizer: FloorLocalizer, settings: TrackerSettings) -> None:
        """Use another localizer of the same floor and other settings; poses and odometry are kept."""
        self._localizer = localizer
        self._settings = self._predictor.settings = settings
        self._unlocated_views = deque(self._unlocated_views, maxlen=settings.joined_views - 1)

    def add_odometry(self, stamp: float, T_odom_base: SE2) -> None:
        """Add an odometry pose at a time [s]."""
        self._predictor.add_odometry(stamp, T_odom_base)

    def set_area(self, T_map_base: SE2, covariance: Floats, level: str = '') -> None:
        """Set an initial pose: only the area around it is searched until the robot is found.

        Args:
            T_map_base: centre of the area.
            covariance: shape (3, 3), covariance of x, y [m] and yaw [rad].
            level: name of the level in whose frame the area is, for a map of several levels.

        Raises:
            FloorLocalizerError: the map has no such level.
        """
        centre = self._localizer.to_map(T_map_base, level)
        self.relocalize()
        radius = _AREA_SIGMAS * math.sqrt(float(np.max(np.linalg.eigvalsh(covariance[:2, :2]))))
        yaw_tolerance = min(_AREA_SIGMAS * math.sqrt(float(covariance[2, 2])), math.pi)
        self._area = PosePrior(centre, radius, yaw_tolerance, is_strict=self._settings.initialpose_is_strict)
        self._area_stamp = math.nan

    def relocalize(self) -> None:
        """Drop all priors, so that the next image is searched in the whole map."""
        self._area = None
        self._predictor.clear_poses()
        self._unlocated_views.clear()
        self._last_thorough = -math.inf

    def track(self, stamp: float, image: Pixels, camera: PinholeCamera) -> Fix | NoFix:
        """Find the pose from the next image at a time [s], on a map of several levels in the frame of its level.

        The node calls this. It runs the ten steps of `FloorLocalizer.locate`: step 1 here, the others in `track_dots`.

        Raises:
            DotImageError: the image is of another type or shape.
        """
        return self.track_dots(stamp, self._localizer.detect(image), camera)

    def track_dots(self, stamp: float, dots: DetectedDots, camera: PinholeCamera) -> Fix | NoFix:
        """Find the pose from the dots of the next image; otherwise as `track`.

        Steps 2 to 9 of `FloorLocalizer.locate` run in `FloorLocalizer.locate_dots`: on this view and, if that is not
        reliable enough, again with the earlier views added. Step 10 is last, so that priors are on the whole map.
        """
        # The prior of step 3 (paper, 4: a rough area): the initial pose, or the prediction from odometry or velocity.
        prior = self._area_at(stamp) or self._predictor.predict(stamp)
        # The budget of steps 4 and 5. A thorough search takes a fifth of a second: one for every image would be slower
        # than the camera.
        thorough = stamp - self._last_thorough >= self._settings.thorough_interval
        effort = self._settings.thorough_effort if thorough else self._settings.usual_effort
        # Steps 2 to 9 on this view alone,
        result = self._localizer.locate_dots(dots, camera, prior, effort=effort)
        if thorough or isinstance(result, Fix):
            self._last_thorough = stamp
        # then on several views together (paper, 4: several places near the robot make it more reliable).
        if self._needs_more_views(result):
            result = self._locate_with_earlier_views(stamp, dots, camera, prior, result)
        # Keep the pose for the next prediction, or the view for the next image.
        if isinstance(result, Fix):
            self._predictor.add_pose(stamp, result.T_map_base)
            self._area = None
            self._unlocated_views.clear()
        else:
            self._unlocated_views.append((stamp, self._localizer.floor_points(dots, camera)))
        # Step 10: the frame of the robot's level.
        return self._localizer.to_level(result)

    def _area_at(self, stamp: float) -> PosePrior | None:
        """Return the area of the initial pose, moved by odometry since the first view after it was set."""
        if self._area is None:
            return None
        if math.isnan(self._area_stamp):
            self._area_stamp = stamp
        step = self._predictor.relative_motion(self._area_stamp, stamp)
        if step is None:
            return self._area
        distance = math.hypot(step.x, step.y)
        radius_error = self._settings.odometry_error * distance
        yaw_error = self._settings.odometry_error * (distance + abs(step.yaw))
        return replace(
            self._area,
            T_map_base=self._area.T_map_base @ step,
            radius=self._area.radius + radius_error,
            yaw_tolerance=min(self._area.yaw_tolerance + yaw_error, math.pi),
        )

    def _needs_more_views(self, result: Fix | NoFix) -> bool:
        """Return whether one view alone is not reliable enough."""
        if isinstance(result, Fix):
            return (
                not result.used_prior and result.expected_chance_alignments > self._settings.chance_alignments_alone_max
            )
        return True

    def _locate_with_earlier_views(
        self, stamp: float, dots: DetectedDots, camera: PinholeCamera, prior: PosePrior | None, single_view: Fix | NoFix
    ) -> Fix | NoFix:
        """Find the pose from this view, merged by odometry with the earlier ones."""
        earlier = self._earlier_points(stamp)
        if earlier is not None:
            effort = self._settings.usual_effort
            merged = self._localizer.locate_dots(dots, camera, prior, earlier=earlier, effort=effort)
            if not self._needs_more_views(merged):
                return merged
        if isinstance(single_view, NoFix):
            return single_view
        detail = f'expected chance alignments {single_view.expected_chance_alignments:.1g}; waiting for a second view'
        return NoFix(NoFixReason.UNCERTAIN, detail, dots)

    def _earlier_points(self, stamp: float) -> FloorPoints | None:
        """Return the dots of the earlier views without a pose, in the current base frame."""
        merged = FloorPoints(np.empty((0, 2)), np.empty(0))
        for view_stamp, points in self._unlocated_views:
            step = self._predictor.relative_motion(view_stamp, stamp)
            if step is not None:
                merged = merge_points(merged, transform_points(points, step.inverse(), self._settings.odometry_error))
        return merged if len(merged.points) else None
