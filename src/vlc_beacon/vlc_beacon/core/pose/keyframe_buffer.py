"""Keyframes of lamp observations joined by odometry: two lamps give a pose even if never seen together."""

import math
from collections import deque

import numpy as np

from shirube_core.geometry import SE2
from vlc_beacon.core.pose.lamp_rays import LampRays

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
        """Start without keyframes."""
        self._keyframes: deque[tuple[SE2, LampRays]] = deque(maxlen=KEYFRAMES_MAX)

    def clear(self) -> None:
        """Drop all keyframes."""
        self._keyframes.clear()

    def add(self, T_odom_base: SE2, rays: LampRays) -> None:
        """Add the lamps of an image as a keyframe, if there are any and the robot has moved."""
        if len(rays) and (not self._keyframes or self._keyframes[-1][0].distance_to(T_odom_base) >= KEYFRAME_SPACING):
            self._keyframes.append((T_odom_base, rays))

    def merged_with(self, T_odom_base: SE2, rays: LampRays) -> LampRays:
        """Return the lamps in view merged with those of earlier keyframes.

        Args:
            T_odom_base: current odometry pose.
            rays: current observations.
        """
        parts = [rays]
        for view, (T_odom_then, observed) in enumerate(self._keyframes, start=1):
            motion = T_odom_base.inverse() @ T_odom_then
            distance = math.hypot(motion.x, motion.y)
            if KEYFRAME_SPACING <= distance <= DISTANCE_MAX:
                parts.append(_transform_rays(observed, motion, distance, view))
        return LampRays(
            *(
                np.concatenate([getattr(part, name) for part in parts])
                for name in ('ids', 'rays', 'pixel_jacobians', 'sigmas', 'motions', 'views')
            )
        )


def _transform_rays(observed: LampRays, motion: SE2, distance: float, view: int) -> LampRays:
    motions = [motion @ SE2(*row) for row in observed.motions.tolist()]
    pixel = np.sqrt(np.abs(np.linalg.det(observed.pixel_jacobians)))
    return LampRays(
        observed.ids,
        observed.rays,
        observed.pixel_jacobians,
        np.hypot(observed.sigmas, DISTANCE_ERROR * distance / LAMP_HEIGHT / pixel),
        np.array([[each.x, each.y, each.yaw] for each in motions]),
        np.full(len(observed), view),
    )
