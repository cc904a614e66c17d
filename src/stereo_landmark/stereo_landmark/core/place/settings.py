"""Settings of the displacement estimate and of its acceptance."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting

REPROJECTION, CLOSED_FORM = 'reprojection', 'closed_form'


@dataclass(frozen=True)
class PlaceSettings:
    """Settings of the displacement estimate."""

    method: str = setting(
        REPROJECTION,
        "minimization of the reprojection error in both images, or the paper's closed form on 3D points",
        choices=(REPROJECTION, CLOSED_FORM),
    )
    points_min: int = setting(3, 'minimum number of points for a pose', minimum=2, maximum=100)
    pixel_sigma: float = setting(
        0.05,
        'calibration error, standard deviation along each axis of each image',
        unit='px',
        minimum=0.0,
        maximum=10.0,
    )
    tilt_sigma: float = setting(
        0.002,
        'standard deviation of the roll and pitch prior; 0 fixes them, 0.5 estimates them from the points',
        unit='rad',
        minimum=0.0,
        maximum=0.5,
    )
    gate_sigmas: float = setting(
        5.0, 'points with a larger Mahalanobis distance are rejected as outliers', minimum=2.0, maximum=20.0
    )
    position_sigma_max: float = setting(
        0.1, 'maximum standard deviation of a published position', unit='m', minimum=0.001, maximum=10.0
    )
