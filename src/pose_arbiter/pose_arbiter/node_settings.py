"""Parameters of the node, without those of the filter and of the sources."""

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class NodeSettings:
    """Frames, output rate and /tf."""

    map_frame: str = setting('map', 'frame of the published poses')
    odom_frame: str = setting('odom', 'frame of the odometry, child of map_frame on /tf')
    base_frame: str = setting('base_link', 'frame of the robot whose pose is published')
    rate: float = setting(50.0, 'rate of the published poses', '1/s', (1.0, 200.0))
    publish_tf: bool = setting(True, 'publish map_frame to odom_frame on /tf, if tf2_msgs is installed')
    transform_tolerance: float = setting(0.1, 'time by which /tf is stamped into the future', 's', (0.0, 5.0))
    initialpose_for: str = setting(
        '', 'source that gets the pose on ~/initialpose when it is silent and others support the pose; empty: none'
    )
