"""What the receiver must know of camera and lamps."""

from __future__ import annotations

from dataclasses import dataclass, field

from shirube_settings import setting
from vlc_beacon.core.lamp_image.settings import LampSettings
from vlc_beacon.core.light_code.manchester import SLOT_BYTES_MAX
from vlc_beacon.core.pose.odometry_settings import OdometrySettings
from vlc_beacon.core.pose.settings import PoseSettings

CENTROID, RADIUS_INTERVAL, RADIUS_INTERVAL_PRINTED = 'centroid', 'radius_interval', 'radius_interval_printed'


@dataclass(frozen=True)
class ReceiverSettings:
    """The camera's shutter, the method of the pose; lamps, pose and odometry in groups."""

    shutter: str = setting(
        'global', 'how the camera exposes: all rows together or row by row', choices=('global', 'rolling')
    )
    row_time: float = setting(
        18.9e-6,
        'time from the beginning of a row to that of the next, of a rolling shutter',
        unit='s',
        minimum=1e-6,
        maximum=1e-3,
    )
    exposure_time: float = setting(
        0.0005, 'how long a row collects light', unit='s', minimum=1e-6, maximum=0.03
    )
    lamp_frame_rate: float = setting(
        30.0,
        'frame rate that the lamps were made for, of a rolling shutter; a global shutter must have 60',
        unit='1/s',
        minimum=5.0,
        maximum=240.0,
    )
    slot_bytes: int = setting(
        1,
        'bytes in a slot of manchester, as the lamps were encoded',
        minimum=1,
        maximum=SLOT_BYTES_MAX,
    )
    method: str = setting(
        CENTROID,
        "how the pose is found: least squares on centres, the paper's intervals, or these as they were printed",
        choices=(CENTROID, RADIUS_INTERVAL, RADIUS_INTERVAL_PRINTED),
    )
    camera_height_known: bool = setting(
        False,
        'whether base_frame is on the floor z = 0 of the map, so that camera_xyz tells the height of the camera',
    )
    blooming: float = setting(
        0.0,
        'how much larger than they are lamps look, for the methods that measure them: beta of a calibration',
        unit='px',
        minimum=0.0,
        maximum=50.0,
    )
    lamps: LampSettings = field(default_factory=LampSettings)
    pose: PoseSettings = field(default_factory=PoseSettings)
    odometry: OdometrySettings = field(default_factory=OdometrySettings)

    @property
    def is_rolling(self) -> bool:
        """Whether the shutter is a rolling one."""
        return self.shutter == 'rolling'
