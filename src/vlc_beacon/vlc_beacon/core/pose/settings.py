"""How exactly lamps and robot are known, and when a lamp is doubted."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class PoseSettings:
    """What the pose of a robot under lamps is computed with.

    The stated covariance follows from these: with lamps that hang where the file says and a camera that is
    calibrated exactly, as in a simulation, it is about twice too wide.
    """

    pixel_sigma: float = setting(
        0.1,
        "error of the camera's calibration, standard deviation along each axis of the image",
        unit='px',
        minimum=0.0,
        maximum=10.0,
    )
    beacon_sigma: float = setting(
        0.002,
        "accuracy of the lamps' positions in the file, standard deviation along each axis",
        unit='m',
        minimum=0.0,
        maximum=1.0,
    )
    tilt_sigma: float = setting(
        0.002,
        'accuracy of the known tilt, standard deviation of roll and of pitch; 0 where it is exact',
        unit='rad',
        minimum=0.0,
        maximum=0.2,
    )
    gate_sigmas: float = setting(
        5.0, 'a lamp that is seen more standard deviations off is doubted', minimum=2.0, maximum=20.0
    )
