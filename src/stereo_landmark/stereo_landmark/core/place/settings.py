"""How the displacement is computed, and when it is believed."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting

REPROJECTION, CLOSED_FORM = 'reprojection', 'closed_form'


@dataclass(frozen=True)
class PlaceSettings:
    """How a displacement follows from points."""

    method: str = setting(
        REPROJECTION,
        "the fit of what both cameras see, or the paper's closed form on points in space",
        choices=(REPROJECTION, CLOSED_FORM),
    )
    points_min: int = setting(3, 'fewer points than this are no landmark', minimum=2, maximum=100)
    pixel_sigma: float = setting(
        0.05,
        'error of the calibration, standard deviation along each axis of each image',
        unit='px',
        minimum=0.0,
        maximum=10.0,
    )
    tilt_sigma: float = setting(
        0.002,
        'how well roll and pitch are known, standard deviation; 0 for exactly, 0.5 lets the points tell them',
        unit='rad',
        minimum=0.0,
        maximum=0.5,
    )
    gate_sigmas: float = setting(
        5.0, 'a point that is seen more standard deviations off is left out', minimum=2.0, maximum=20.0
    )
    position_sigma_max: float = setting(
        0.1, 'a position that is less certain than this is no fix', unit='m', minimum=0.001, maximum=10.0
    )
