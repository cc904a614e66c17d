"""ROS parameters of the node; the parameters of the method are settings of the core."""

import math
from dataclasses import dataclass

from shirube_core.settings import setting, tunable
from shirube_ros.camera.settings import CameraSettings
from stereo_landmark.core.settings import PairSettings


@tunable('queue_size', fixed=('queue_size',))  # none: the mount must equal that of the teaching
@dataclass(frozen=True)
class NodeSettings(PairSettings, CameraSettings):
    """Camera mount, frames, places and synchronization."""

    camera_xyz: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.5),
        "position of the left camera's optical frame in base_frame; must equal the value at teaching",
        'm',
        (-10.0, 10.0),
    )
    camera_rpy: tuple[float, float, float] = setting(
        (-math.pi / 2.0, 0.0, -math.pi / 2.0),
        'fixed-axis roll, pitch, yaw of the rectified left optical frame in base_frame; default: forward',
        'rad',
        (-math.tau, math.tau),
    )
    places_dir: str = setting('', 'folder of the taught places; required')
