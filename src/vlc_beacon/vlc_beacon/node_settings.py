"""The node's parameters besides those of light and trust, which are the core's own settings."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from shirube_ros.camera_settings import CameraSettings
from shirube_settings import setting
from vlc_beacon.core.drive.drive_settings import DriveSettings


@dataclass(frozen=True)
class NodeSettings(CameraSettings):
    """Where the camera sits, which frames the poses connect, which lamps, whose commands; driving in a group."""

    camera_xyz: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.2),
        'position of the optical frame in base_frame, whose plane z = 0 is the floor',
        unit='m',
        minimum=-10.0,
        maximum=10.0,
    )
    camera_rpy: tuple[float, float, float] = setting(
        (0.0, 0.0, math.pi / 2.0),
        "fixed-axis roll, pitch, yaw of the optical frame in base_frame; by default up, the image's upper edge ahead",
        unit='rad',
        minimum=-math.tau,
        maximum=math.tau,
    )
    beacons_file: str = setting('', 'YAML file of the lamps and their places; there is none by default')
    key_file: str = setting(
        '', 'file with the secret that commands are signed with; without one all commands are refused'
    )
    counter_file: str = setting('', 'file that keeps the counters of commands over restarts')
    drive: bool = setting(False, 'whether the node drives the robot as the lamps say, on ~/cmd_vel')
    driving: DriveSettings = field(default_factory=DriveSettings)
