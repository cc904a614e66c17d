"""Example results of a localizer."""

from dataclasses import replace

import numpy as np
from floor_views import dots_at

from floor_localizer.core.fix import Fix, NoFix, NoFixReason
from shirube_core.geometry import SE2

POSE = SE2(1.25, -0.5, 2.0)
COVARIANCE = np.diag([1e-8, 4e-8, 1e-6])
REASON = next(iter(NoFixReason))


def a_fix() -> Fix:
    return Fix(
        T_map_base=POSE,
        covariance=COVARIANCE,
        dots=replace(dots_at([[30.0, 40.0], [200.0, 60.0], [100.0, 210.0]]), diameters=np.full(3, 8.0)),
        matched=np.array([True, False, True]),
        map_points=np.array([[1.2, -0.5], [np.nan, np.nan], [1.3, -0.45]]),
        match_rate=0.67,
        scale=0.01,
        tilt=(0.001, -0.002),
        used_prior=True,
        expected_chance_alignments=1e-9,
    )


def no_fix() -> NoFix:
    return NoFix(REASON, '2 of 7', dots_at([117.0, 117.0]))
