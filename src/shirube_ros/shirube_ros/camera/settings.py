"""Parameters of every node with a camera."""

import math
from dataclasses import dataclass

from shirube_core.geometry import CameraMount
from shirube_core.settings import setting, tunable

_DOWNWARD = CameraMount()


@tunable('camera_xyz', 'camera_rpy')
@dataclass(frozen=True)
class CameraSettings:
    """Camera extrinsics, frames and image transport."""

    camera_xyz: tuple[float, float, float] = setting(
        _DOWNWARD.xyz, 'position of the optical frame in base_frame, whose plane z = 0 is the floor', 'm', (-10.0, 10.0)
    )
    camera_rpy: tuple[float, float, float] = setting(
        _DOWNWARD.rpy, 'fixed-axis roll, pitch, yaw of the optical frame in base_frame', 'rad', (-math.tau, math.tau)
    )
    map_frame: str = setting('map', 'frame in which poses are published')
    base_frame: str = setting('base_link', 'frame of the robot whose pose is published')
    image_transport: str = setting(
        'auto',
        'raw images, CompressedImage on <topic>/compressed, or auto: the first that arrives',
        choices=('auto', 'raw', 'compressed'),
    )

    @property
    def mount(self) -> CameraMount:
        """The pose of the optical frame in ``base_frame``."""
        return CameraMount(self.camera_xyz, self.camera_rpy)
