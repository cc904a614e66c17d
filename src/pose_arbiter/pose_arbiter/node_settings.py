"""The node's parameters besides those of the method and of the sources."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class NodeSettings:
    """Frames, and how often the pose is told."""

    map_frame: str = setting('map', 'frame in which poses are told')
    odom_frame: str = setting('odom', 'frame of the odometry, child of map_frame on /tf')
    base_frame: str = setting('base_link', 'frame of the robot whose pose is told')
    rate: float = setting(50.0, 'poses a second', unit='1/s', minimum=1.0, maximum=200.0)
    publish_tf: bool = setting(
        True, 'whether map_frame to odom_frame is told on /tf, where tf2_ros is installed'
    )
    transform_tolerance: float = setting(
        0.1, 'how far ahead of now /tf is stamped', unit='s', minimum=0.0, maximum=5.0
    )
