"""Compiles the numba kernels of the collision monitor before the first measurement."""

import numpy as np

from reward_planner.core.safety.collision_monitor import CollisionMonitor
from reward_planner.core.safety.range_frame import range_frame
from reward_planner.core.safety.safety_settings import CollisionMonitorSettings, SourceSettings


def compile_kernels() -> None:
    """Compile the kernels: take measurements of something that comes nearer, and decide."""
    monitor = CollisionMonitor(CollisionMonitorSettings(), {'source': SourceSettings(points_min=1)})
    for now, x in ((1.0, 2.0), (1.1, 1.0), (1.2, 0.9)):
        points = np.array([[x, 0.01 * k, 0.0] for k in range(-30, 30)], dtype=np.float32)
        frame = range_frame(points, np.ones(60, dtype=np.bool_), np.eye(3), np.array([0.0, 0.0, 0.3]))
        monitor.add_command(now, 0.5, 0.0)
        monitor.add_frame('source', now, now, frame)
        monitor.decide(now)
