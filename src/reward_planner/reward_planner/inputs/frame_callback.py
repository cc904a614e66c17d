"""Type of the inputs' callback."""

from __future__ import annotations

from collections.abc import Callable

from std_msgs.msg import Header

from reward_planner.core.navigator import SensorFrame

FrameCallback = Callable[[Header, SensorFrame], None]
"""Called with the header of a message and its points in the optical frame of the camera."""
