"""Measurement noise and outlier gate of the pose."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class PoseSettings:
    """Noise settings of the pose estimation.

    The published covariance follows from these. With exact lamp positions and calibration, as in simulation, the
    standard deviations are about twice too large.
    """

    pixel_sigma: float = setting(
        0.1,
        'standard deviation of the camera calibration along each image axis',
        unit='px',
        minimum=0.0,
        maximum=10.0,
    )
    beacon_sigma: float = setting(
        0.002,
        'standard deviation of the lamp positions in the file along each axis',
        unit='m',
        minimum=0.0,
        maximum=1.0,
    )
    tilt_sigma: float = setting(
        0.002,
        'standard deviation of the known roll and pitch; 0 if exact',
        unit='rad',
        minimum=0.0,
        maximum=0.2,
    )
    gate_sigmas: float = setting(
        5.0,
        'outlier gate: a lamp with a larger residual, in standard deviations, is rejected',
        minimum=2.0,
        maximum=20.0,
    )
