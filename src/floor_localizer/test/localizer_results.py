"""Example results of a localizer."""

import numpy as np

from floor_localizer.core.dots import DetectedDots
from floor_localizer.core.fix import Fix, NoFix, NoFixReason
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

CAMERA = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
MOUNT = CameraMount(xyz=(0.05, -0.02, 0.13))
POSE = SE2(1.25, -0.5, 2.0)
COVARIANCE = np.diag([1e-8, 4e-8, 1e-6])
REASON = next(iter(NoFixReason))


def dots_of(*pixels: tuple[float, float]) -> DetectedDots:
    number = len(pixels)
    return DetectedDots(
        np.array(pixels, dtype=np.float64).reshape(-1, 2), np.full(number, 8.0), np.full(number, 0.1)
    )


def a_fix(pose: SE2 = POSE) -> Fix:
    return Fix(
        T_map_base=pose,
        covariance=COVARIANCE,
        dots=dots_of((30.0, 40.0), (200.0, 60.0), (100.0, 210.0)),
        matched=np.array([True, False, True]),
        map_points=np.array([[1.2, -0.5], [np.nan, np.nan], [1.3, -0.45]]),
        match_rate=0.67,
        scale=0.01,
        tilt=(0.001, -0.002),
        used_prior=True,
        expected_chance_alignments=1e-9,
    )


def no_fix() -> NoFix:
    return NoFix(REASON, '2 of 7', dots_of((117.0, 117.0)))
