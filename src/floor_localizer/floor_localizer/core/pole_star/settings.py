"""Settings of the pole-star pipeline."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class PoleStarSettings:
    """Settings of the paper's matching; values that it does not give have defaults for its floor and 1 px of noise."""

    radius: float = setting(0.09, 'pole-star radius', unit='m', minimum=0.001, maximum=10.0)
    quantum: float = setting(0.0005, 'quantization step of distances', unit='m', minimum=1e-6, maximum=0.1)
    vote_tolerance: float = setting(
        0.00075,
        'maximum difference between a distance and those it votes for',
        unit='m',
        minimum=1e-6,
        maximum=0.1,
    )
    pairs_per_region: int = setting(
        90, 'expected number of random candidates in a region, over all image dots', minimum=1, maximum=1000
    )
    grid_pitch: float = setting(
        0.06, 'distance between the nodes where overlap is counted', unit='m', minimum=0.001, maximum=10.0
    )
    overlap_min: int = setting(5, 'minimum number of image dots of a region', minimum=2, maximum=1000)
    congruence_tolerance: float = setting(
        0.0016, 'maximum difference of two equal distances', unit='m', minimum=1e-6, maximum=0.1
    )
    congruent_min: int = setting(5, 'minimum number of congruent pairs of a pose', minimum=2, maximum=1000)
    address_block: float = setting(
        0.0028, 'side of a block of the address matrix', unit='m', minimum=1e-4, maximum=0.1
    )
    match_rate_min: float = setting(0.31, 'minimum match rate of a pose', minimum=0.0, maximum=1.0)
