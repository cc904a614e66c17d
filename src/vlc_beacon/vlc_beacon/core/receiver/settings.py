"""Receiver settings of camera and lamps."""

from __future__ import annotations

from dataclasses import dataclass, field

from shirube_core.settings import setting
from vlc_beacon.core.lamp_image.settings import LampSettings
from vlc_beacon.core.light_code.manchester import SEGMENT_BYTES_MAX
from vlc_beacon.core.pose.odometry_settings import OdometrySettings
from vlc_beacon.core.pose.settings import PoseSettings

CENTROID, RADIUS_INTERVAL, RADIUS_INTERVAL_PRINTED = 'centroid', 'radius_interval', 'radius_interval_printed'


@dataclass(frozen=True)
class ReceiverSettings:
    """Camera shutter and pose method, with groups for lamps, pose and odometry."""

    shutter: str = setting(
        'global', 'camera shutter: all rows exposed together or row by row', choices=('global', 'rolling')
    )
    row_time: float = setting(
        18.9e-6,
        'line time of a rolling shutter, from the start of a row to that of the next',
        unit='s',
        minimum=1e-6,
        maximum=1e-3,
    )
    exposure_time: float = setting(0.0005, 'exposure of a row', unit='s', minimum=1e-6, maximum=0.03)
    lamp_frame_rate: float = setting(
        30.0,
        'frame rate the lamps were encoded for, with a rolling shutter; a global shutter must run at 60',
        unit='1/s',
        minimum=5.0,
        maximum=240.0,
    )
    segment_bytes: int = setting(
        1,
        'bytes per Manchester segment, as the lamps were encoded',
        minimum=1,
        maximum=SEGMENT_BYTES_MAX,
        former_name='slot_bytes',
    )
    method: str = setting(
        CENTROID,
        "pose method: least squares on centroids, the paper's intervals corrected, or the paper's as printed",
        choices=(CENTROID, RADIUS_INTERVAL, RADIUS_INTERVAL_PRINTED),
    )
    camera_height_known: bool = setting(
        False,
        'whether base_frame is on the floor z = 0 of the map, so that camera_xyz gives the height of the camera',
    )
    blooming: float = setting(
        0.0,
        'increase of the apparent lamp radius, for the radius_interval methods: beta of calibrate',
        unit='px',
        minimum=0.0,
        maximum=50.0,
    )
    lamps: LampSettings = field(default_factory=LampSettings)
    pose: PoseSettings = field(default_factory=PoseSettings)
    odometry: OdometrySettings = field(default_factory=OdometrySettings)

    @property
    def is_rolling(self) -> bool:
        """Whether the camera has a rolling shutter."""
        return self.shutter == 'rolling'
