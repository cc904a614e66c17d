"""The node's parameters besides those of the method, which are the core's own settings."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from reward_planner.core.depth.depth_settings import DepthSettings, refuse_unmatchable
from shirube_ros.camera_settings import CameraSettings
from shirube_settings import setting


@dataclass(frozen=True)
class NodeSettings(CameraSettings):
    """What the robot sees with, which frames poses connect, which map it begins with, and whether it drives."""

    camera_xyz: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.3),
        'position of the (left) optical frame in base_frame, whose plane z = 0 is the floor',
        unit='m',
        minimum=-10.0,
        maximum=10.0,
    )
    camera_rpy: tuple[float, float, float] = setting(
        (-math.pi / 2.0, 0.0, -math.pi / 2.0),
        'fixed-axis roll, pitch, yaw of the (left) optical frame in base_frame; by default level and ahead',
        unit='rad',
        minimum=-math.tau,
        maximum=math.tau,
    )
    source: str = setting(
        'points',
        'what the robot sees with: a point cloud, a depth image, or three cameras (left, right, top)',
        choices=('points', 'depth', 'trinocular'),
    )
    camera_frame: str = setting(
        '',
        'optical frame of the camera whose mount this is, for source points; empty takes the first *_optical_frame '
        'that comes, others are refused',
    )
    map_file: str = setting('', 'map (YAML of map_server) to begin with; empty begins with nothing known')
    save_file: str = setting('', 'where ~/save_map writes (YAML, with a PGM beside it); empty takes map_file')
    drive: bool = setting(False, 'whether the node drives the robot, on cmd_vel')
    depth: DepthSettings = field(default_factory=DepthSettings)


def check_source(node: NodeSettings) -> None:
    """Refuse settings that do not fit the source, before its first message comes.

    Raises:
        DepthError: matching of three cameras that OpenCV cannot do.
    """
    if node.source == 'trinocular':
        refuse_unmatchable(node.depth)
