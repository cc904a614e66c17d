"""The node's parameters besides those of the method, which are the core's own settings."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shirube_ros.camera_settings import CameraSettings
from shirube_settings import setting
from stereo_landmark.core.pair.settings import PairSettings


@dataclass(frozen=True)
class NodeSettings(PairSettings, CameraSettings):
    """Where the left camera sits, which frames the poses connect, which places, how images pair."""

    camera_xyz: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.5),
        "position of the left camera's optical frame in base_frame; as when the places were taught",
        unit='m',
        minimum=-10.0,
        maximum=10.0,
    )
    camera_rpy: tuple[float, float, float] = setting(
        (-math.pi / 2.0, 0.0, -math.pi / 2.0),
        'fixed-axis roll, pitch, yaw of that frame, as rectified, in base_frame; by default it looks ahead',
        unit='rad',
        minimum=-math.tau,
        maximum=math.tau,
    )
    places_dir: str = setting('', 'folder of the taught places; there is none by default')
