"""Settings of one source of poses."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class SourceSettings:
    """Settings of one localizer; its parameters are called ``<name>.topic`` and so on."""

    topic: str = setting(
        '', 'topic of its poses; empty: /<name>/pose_with_covariance, or /<name>/pose without covariance'
    )
    with_covariance: bool = setting(
        True, 'true: the topic is PoseWithCovarianceStamped; false: PoseStamped with the sigmas below'
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
        'standard deviation of the yaw of poses without covariance',
        unit='rad',
        minimum=1e-6,
        maximum=math.pi,
    )
    timeout: float = setting(
        1.0,
        'a source without a message for this long is ignored',
        unit='s',
        minimum=0.05,
        maximum=60.0,
    )
    priority: int = setting(
        0, 'at start, decides between two sources that disagree', minimum=-100, maximum=100
    )
    frame: str = setting('', 'required frame_id of its poses; empty: map_frame')
    offset: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.0),
        'pose (x, y, yaw) of base_frame in the frame that the source localizes; zeros if that is base_frame',
        unit='m, m, rad',
        minimum=-100.0,
        maximum=100.0,
    )
