"""The image processing that is taught for a place (paper 3.3b, 4a)."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class EdgeSettings:
    """From the grey image to segments: spatial filter, threshold, noise removal, line following.

    The paper also teaches how often the binary image is thinned. Here an edge is the maximum of the
    gradient along its own direction, so it is one pixel wide whatever the image.
    """

    filter_sigma: float = setting(
        1.0,
        'standard deviation of the Gaussian whose derivative is taken',
        unit='px',
        minimum=0.5,
        maximum=5.0,
    )
    threshold: float = setting(
        6.0,
        'gradient that a segment must reach somewhere, in grey levels a pixel',
        minimum=0.5,
        maximum=200.0,
    )
    continuation: float = setting(
        0.4, 'part of the threshold at which a segment still goes on', minimum=0.1, maximum=1.0
    )
    length_min: float = setting(
        8.0, 'shorter segments are noise and removed', unit='px', minimum=2.0, maximum=1000.0
    )
    bend_tolerance: float = setting(
        0.8, 'distance of a segment from its polyline', unit='px', minimum=0.3, maximum=10.0
    )
