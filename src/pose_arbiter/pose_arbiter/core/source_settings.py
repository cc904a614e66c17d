"""What the owner says of one source of poses."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class SourceSettings:
    """One localizer; the parameters are called ``<name>.topic`` and so on."""

    topic: str = setting(
        '', 'its poses; empty takes /<name>/pose_with_covariance, or /<name>/pose without covariance'
    )
    with_covariance: bool = setting(
        True, 'whether the topic is PoseWithCovarianceStamped; if not, PoseStamped with the sigmas below'
    )
    sigma_xy: float = setting(
        0.01,
        'standard deviation along x and y of poses without covariance',
        unit='m',
        minimum=1e-6,
        maximum=10.0,
    )
    sigma_yaw: float = setting(
        0.01,
        'standard deviation of the heading of poses without covariance',
        unit='rad',
        minimum=1e-6,
        maximum=math.pi,
    )
    timeout: float = setting(
        1.0,
        'silent for longer, it speaks no more for or against the pose',
        unit='s',
        minimum=0.05,
        maximum=60.0,
    )
    priority: int = setting(
        0, 'at the start the highest is believed where opinions differ one to one', minimum=-100, maximum=100
    )
    frame: str = setting('', 'frame its poses must be in; empty takes map_frame')
    offset: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.0),
        'pose (x, y, yaw) of base_frame in the frame whose pose it tells; zeros where that is base_frame',
        unit='m, m, rad',
        minimum=-100.0,
        maximum=100.0,
    )
