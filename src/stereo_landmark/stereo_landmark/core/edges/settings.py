"""Edge detection settings, taught for each place (paper 3.3b, 4a)."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class EdgeSettings:
    """Edge detection and linking: spatial filter, hysteresis thresholds, noise removal, polylines.

    The paper also teaches the number of thinning passes. Here non-maximum suppression makes every edge
    one pixel wide, so that parameter does not exist.
    """

    filter_sigma: float = setting(
        1.0,
        'standard deviation of the Gaussian derivative filter',
        unit='px',
        minimum=0.5,
        maximum=5.0,
    )
    threshold: float = setting(
        6.0,
        'upper hysteresis threshold: gradient that a segment must reach at one point [grey levels / px]',
        minimum=0.5,
        maximum=200.0,
    )
    continuation: float = setting(
        0.4, 'lower hysteresis threshold as a fraction of threshold', minimum=0.1, maximum=1.0
    )
    length_min: float = setting(
        8.0, 'minimum segment length; shorter segments are noise', unit='px', minimum=2.0, maximum=1000.0
    )
    bend_tolerance: float = setting(
        0.8, 'tolerance of the polyline approximation (Douglas-Peucker)', unit='px', minimum=0.3, maximum=10.0
    )
