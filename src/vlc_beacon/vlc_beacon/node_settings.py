"""Parameters of the node, except those of the receiver and of the command authorization."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from shirube_core.settings import setting
from shirube_ros.camera.settings import CameraSettings
from vlc_beacon.core.drive.drive_settings import DriveSettings


@dataclass(frozen=True)
class NodeSettings(CameraSettings):
    """Camera mount, frames, files and drive mode; drive parameters in a group."""

    camera_xyz: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.2),
        'position of the optical frame in base_frame, whose plane z = 0 is the floor',
        unit='m',
        minimum=-10.0,
        maximum=10.0,
    )
    camera_rpy: tuple[float, float, float] = setting(
        (0.0, 0.0, math.pi / 2.0),
        'fixed-axis roll, pitch, yaw of the optical frame in base_frame; default: upward, top of the image ahead',
        unit='rad',
        minimum=-math.tau,
        maximum=math.tau,
    )
    beacons_file: str = setting('', 'beacons file: YAML of lamp IDs and positions; required')
    key_file: str = setting('', 'key file of the commands; without a key all commands are rejected')
    counter_file: str = setting('', 'file that stores the counters of commands over restarts')
    drive: bool = setting(False, 'whether the node executes commands and publishes ~/cmd_vel')
    driving: DriveSettings = field(default_factory=DriveSettings)
