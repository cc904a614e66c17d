"""Parameters of the node; those of mapping, planning and control are settings of the core."""

import math
from dataclasses import dataclass, field

from reward_planner.core.settings import DepthSettings, check_matcher_settings
from shirube_core.settings import setting
from shirube_ros.camera.settings import CameraSettings


@dataclass(frozen=True)
class NodeSettings(CameraSettings):
    """Sensor source, frames, map files and whether the node drives the robot."""

    camera_xyz: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.3),
        'position of the (left) optical frame in base_frame; the floor is its plane z = 0',
        'm',
        (-10.0, 10.0),
    )
    camera_rpy: tuple[float, float, float] = setting(
        (-math.pi / 2.0, 0.0, -math.pi / 2.0),
        'fixed-axis roll, pitch, yaw of the (left) optical frame in base_frame; default: level, looking ahead',
        'rad',
        (-math.tau, math.tau),
    )
    source: str = setting(
        'points',
        'obstacle source: point cloud, depth image, or three cameras (left, right, top)',
        choices=('points', 'depth', 'trinocular'),
    )
    camera_frame: str = setting(
        '',
        'optical frame of the camera of camera_xyz and camera_rpy, for source points; empty takes the first '
        '*_optical_frame received, others are rejected',
    )
    map_file: str = setting('', 'initial map (YAML of map_server); empty starts with an empty map')
    save_file: str = setting(
        '', 'output file of ~/save_map (YAML; the PGM is in the same folder); empty takes map_file'
    )
    keepout_mask_file: str = setting(
        '',
        'mask of areas that routes do not enter (YAML of map_server, as for KeepoutFilter of Nav2): 100 is forbidden '
        "to the robot's centre, 1 to 99 is a cost; empty for none",
    )
    speed_mask_file: str = setting(
        '',
        'mask of speed limits (YAML of map_server, as for SpeedFilter of Nav2): speed_mask_base + '
        'speed_mask_multiplier * value, at least 5 % of max_linear_velocity; 0 and unknown do not limit; empty: none',
    )
    speed_mask_type: str = setting(
        'percent',
        'unit of the speed limits: percent of max_linear_velocity (type 1 of CostmapFilterInfo) or m/s (type 2)',
        choices=('percent', 'absolute'),
    )
    speed_mask_base: float = setting(100.0, 'speed limit of a mask at value 0', limits=(-1e4, 1e4))
    speed_mask_multiplier: float = setting(
        -1.0, 'change of the speed limit of a mask from each value to the next', limits=(-1e4, 1e4)
    )
    drive: bool = setting(False, 'whether the node drives the robot by cmd_vel')
    planning_thread: bool = setting(
        True,
        'whether routes are planned beside the control loop, which then publishes cmd_vel without gaps; false for '
        'replays in lockstep, whose results do not depend on the computing time',
    )
    depth: DepthSettings = field(default_factory=DepthSettings)


def check_source(node: NodeSettings) -> None:
    """Raise a RewardPlannerError for settings of the source that OpenCV does not support."""
    if node.source == 'trinocular':
        check_matcher_settings(node.depth)
