"""Settings of the receiver and of the command authorization; the node declares each as a parameter."""

from dataclasses import dataclass, field

from shirube_core.settings import setting, tunable
from vlc_beacon.core.light_code.manchester import SEGMENT_BYTES_MAX, SegmentFormat


@tunable()
@dataclass(frozen=True)
class LampSettings:
    """Lamp detection in an image."""

    contrast_min: float = setting(
        5.0, 'minimum contrast of a lamp above its background, in grey levels', limits=(2.0, 200.0)
    )
    noise_sigmas: float = setting(
        4.0, 'minimum contrast of a lamp in standard deviations of the noise', limits=(1.0, 20.0)
    )
    diameter_min: float = setting(
        4.0,
        'minimum diameter of a tracked lamp; ufsook is decoded from 6, rs_fsk from 12 to 16 at a row_time of 18.9 us, '
        'manchester from 320',
        'px',
        (2.0, 1000.0),
    )
    diameter_max: float = setting(
        120.0,
        'maximum lamp diameter; manchester needs lamps of 320 or more at a row_time of 18.9 us, so set 450, but '
        'windows and ceiling lights of that size are then processed too',
        'px',
        (4.0, 4000.0),
    )
    roundness_min: float = setting(
        0.4, 'minimum width over length of a lamp, one half of which may be dark', limits=(0.0, 1.0)
    )
    stripe_rows: float = setting(
        0.0,
        'maximum height of a dark band in a lamp under a rolling shutter; 0 to derive it from the light codes',
        'px',
        (0.0, 1000.0),
    )
    lamps_max: int = setting(
        64, 'maximum number of lamp candidates per image; the brightest are used', limits=(1, 1000)
    )


@tunable()
@dataclass(frozen=True)
class PoseSettings:
    """Noise settings of the pose estimation.

    The published covariance follows from these. With exact lamp positions and calibration, as in simulation, the
    standard deviations are about twice too large.
    """

    pixel_sigma: float = setting(
        0.1, 'standard deviation of the camera calibration along each image axis', 'px', (0.0, 10.0)
    )
    beacon_sigma: float = setting(
        0.002, 'standard deviation of the lamp positions in the file along each axis', 'm', (0.0, 1.0)
    )
    tilt_sigma: float = setting(0.002, 'standard deviation of the known roll and pitch; 0 if exact', 'rad', (0.0, 0.2))
    gate_sigmas: float = setting(
        5.0, 'outlier gate: a lamp with a larger residual, in standard deviations, is rejected', limits=(2.0, 20.0)
    )


@tunable()
@dataclass(frozen=True)
class OdometrySettings:
    """Errors of the odometry, and limits of dead reckoning between lamps.

    The biases are estimated while lamps are in view. The defaults of the random errors are those of good wheels with a
    large wheel separation; wheels that slip by s per metre, separated by b, rotate the robot by s sqrt(2) / b. If set
    too small, the covariance after a gap is too small.
    """

    scale_error: float = setting(0.02, 'bias of the driven distance and of yaw, as a fraction', limits=(0.0, 0.5))
    turn_error: float = setting(0.0035, 'bias of yaw per metre driven', 'rad/m', (0.0, 0.5))
    slip: float = setting(
        0.002,
        'random error of the distance after one metre; it grows with the square root of the distance',
        'm',
        (0.0, 1.0),
    )
    turn_slip: float = setting(0.005, 'random error of yaw after one metre or one radian', 'rad', (0.0, 1.0))
    bias_correlation_length: float = setting(
        20.0, 'correlation length of the odometry biases', 'm', (0.1, 10000.0), former_name='lasting_way'
    )
    position_sigma_max: float = setting(
        0.3, 'maximum position standard deviation; above it the pose is reset', 'm', (0.01, 10.0)
    )
    gap_distance_max: float = setting(
        3.0,
        'maximum dead reckoning distance without a lamp for which poses are published; a radian counts as 0.3 m',
        'm',
        (0.0, 1000.0),
        former_name='gap_way',
    )


CENTROID, RADIUS_INTERVAL, RADIUS_INTERVAL_PRINTED = 'centroid', 'radius_interval', 'radius_interval_printed'


@tunable('method', 'blooming')
@dataclass(frozen=True)
class ReceiverSettings:
    """Camera shutter and pose method, with groups for lamps, pose and odometry."""

    shutter: str = setting(
        'global', 'camera shutter: all rows exposed together or row by row', choices=('global', 'rolling')
    )
    row_time: float = setting(
        18.9e-6, 'line time of a rolling shutter, from the start of a row to that of the next', 's', (1e-6, 1e-3)
    )
    exposure_time: float = setting(0.0005, 'exposure of a row', 's', (1e-6, 0.03))
    lamp_frame_rate: float = setting(
        30.0,
        'frame rate the lamps were encoded for, with a rolling shutter; a global shutter must run at 60',
        '1/s',
        (5.0, 240.0),
    )
    segment_bytes: int = setting(
        1,
        'bytes per Manchester segment, as the lamps were encoded',
        limits=(1, SEGMENT_BYTES_MAX),
        former_name='slot_bytes',
    )
    method: str = setting(
        CENTROID,
        "pose method: least squares on centroids, the paper's intervals corrected, or the paper's as printed",
        choices=(CENTROID, RADIUS_INTERVAL, RADIUS_INTERVAL_PRINTED),
    )
    camera_height_known: bool = setting(
        False, 'whether base_frame is on the floor z = 0 of the map, so that camera_xyz gives the height of the camera'
    )
    blooming: float = setting(
        0.0,
        'increase of the apparent lamp radius, for the radius_interval methods: beta of calibrate',
        'px',
        (0.0, 50.0),
    )
    lamps: LampSettings = field(default_factory=LampSettings)
    pose: PoseSettings = field(default_factory=PoseSettings)
    odometry: OdometrySettings = field(default_factory=OdometrySettings)

    @property
    def is_rolling(self) -> bool:
        """Whether the camera has a rolling shutter."""
        return self.shutter == 'rolling'

    @property
    def segment_format(self) -> SegmentFormat:
        """Format of the Manchester segments that the lamps send."""
        return SegmentFormat(self.segment_bytes, frame_rate=self.lamp_frame_rate)


@tunable('speed_limit', 'zone_radius', 'position_age_max')
@dataclass(frozen=True)
class AuthorizationSettings:
    """Conditions for accepting a command."""

    speed_limit: float = setting(0.5, 'maximum speed of any command', 'm/s', (0.0, 10.0))
    zone_radius: float = setting(
        0.3, 'maximum horizontal distance to its beacon at which a command is accepted', 'm', (0.05, 50.0)
    )
    position_age_max: float = setting(1.0, 'maximum age of the position used to accept commands', 's', (0.01, 60.0))
    bad_macs_max: int = setting(5, 'number of wrong authentication codes that triggers the lockout', limits=(1, 1000))
    lockout_time: float = setting(
        60.0, 'time window of wrong authentication codes, and duration of the lockout', 's', (1.0, 86400.0)
    )
