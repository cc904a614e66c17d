"""Keyframes of lamp observations joined by odometry: two lamps give a pose even if never seen together."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from shirube_geometry import PlanarPose
from vlc_beacon.core.pose.lamp_rays import LampRays

VIEWS_MAX = 12
SPACING = 0.1
"""Minimum distance between keyframes [m]."""
WAY_MAX = 3.0
"""Maximum distance to a used keyframe [m]."""
WAY_ERROR = 0.025
"""Odometry error between keyframes as a fraction of the distance."""
REACH = 2.0
"""Typical height of lamps above the camera [m], to convert the odometry error to a ray error."""


class JoinedViews:
    """Recent lamp observations with their odometry poses."""

    def __init__(self) -> None:
        """Start without keyframes."""
        self._views: deque[tuple[PlanarPose, LampRays]] = deque(maxlen=VIEWS_MAX)

    def clear(self) -> None:
        """Drop all keyframes."""
        self._views.clear()

    def add(self, T_odom_base: PlanarPose, rays: LampRays) -> None:
        """Add the lamps of an image as a keyframe, if there are any and the robot has moved."""
        if len(rays) and (not self._views or self._views[-1][0].distance_to(T_odom_base) >= SPACING):
            self._views.append((T_odom_base, rays))

    def seen_from(self, T_odom_base: PlanarPose, rays: LampRays) -> LampRays:
        """Return the lamps in view merged with those of earlier keyframes.

        Args:
            T_odom_base: current odometry pose.
            rays: current observations.
        """
        parts = [rays]
        for view, (then, seen) in enumerate(self._views, start=1):
            motion = T_odom_base.inverse() @ then
            way = math.hypot(motion.x, motion.y)
            if SPACING <= way <= WAY_MAX:
                parts.append(_moved(seen, motion, way, view))
        return LampRays(
            *(
                np.concatenate([getattr(part, name) for part in parts])
                for name in ('ids', 'rays', 'spreads', 'sigmas', 'motions', 'views')
            )
        )


def _moved(seen: LampRays, motion: PlanarPose, way: float, view: int) -> LampRays:
    motions = [motion @ PlanarPose(*row) for row in seen.motions.tolist()]
    pixel = np.sqrt(np.abs(np.linalg.det(seen.spreads)))
    return LampRays(
        seen.ids,
        seen.rays,
        seen.spreads,
        np.hypot(seen.sigmas, WAY_ERROR * way / REACH / pixel),
        np.array([[each.x, each.y, each.yaw] for each in motions]),
        np.full(len(seen), view),
    )
