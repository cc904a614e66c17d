"""Lamps that were seen one after the other, joined by odometry: two make a pose though never seen together."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from shirube_geometry import PlanarPose
from vlc_beacon.core.pose.lamp_rays import LampRays

VIEWS_MAX = 12
SPACING = 0.1
"""Views are kept this far apart [m]."""
WAY_MAX = 3.0
"""Older views than this are dropped [m]."""
WAY_ERROR = 0.025
"""Error of the way between two views as a share, for rays to lamps"""
REACH = 2.0
"""that are about so far over the camera [m]."""


class JoinedViews:
    """The last views of lamps and where the robot was."""

    def __init__(self) -> None:
        """Begin without any."""
        self._views: deque[tuple[PlanarPose, LampRays]] = deque(maxlen=VIEWS_MAX)

    def clear(self) -> None:
        """Forget all views."""
        self._views.clear()

    def add(self, T_odom_base: PlanarPose, rays: LampRays) -> None:
        """Take the lamps of an image; without any it is no view."""
        if len(rays) and (not self._views or self._views[-1][0].distance_to(T_odom_base) >= SPACING):
            self._views.append((T_odom_base, rays))

    def seen_from(self, T_odom_base: PlanarPose, rays: LampRays) -> LampRays:
        """Return the lamps in view together with those of earlier views.

        Args:
            T_odom_base: of now.
            rays: of now.
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
