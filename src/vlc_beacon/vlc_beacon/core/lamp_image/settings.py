"""What is taken for a lamp."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class LampSettings:
    """How lamps are found in an image."""

    contrast_min: float = setting(
        5.0, 'a lamp is so many grey levels brighter than what is around it', minimum=2.0, maximum=200.0
    )
    noise_sigmas: float = setting(
        4.0, 'and so many standard deviations of the noise', minimum=1.0, maximum=20.0
    )
    diameter_min: float = setting(
        4.0,
        'smallest lamp that is followed; ufsook is read from 6, rs_fsk from 12 to 16 at a row time of 18.9 us, '
        'manchester from 320 there',
        unit='px',
        minimum=2.0,
        maximum=1000.0,
    )
    diameter_max: float = setting(
        120.0,
        'largest lamp; manchester needs lamps of 320 and more at a row time of 18.9 us, so 450 here, but windows and '
        'ceiling lights of such a size are then looked at, too',
        unit='px',
        minimum=4.0,
        maximum=4000.0,
    )
    roundness_min: float = setting(
        0.4, 'width over length of a lamp of which one half may be dark', minimum=0.0, maximum=1.0
    )
    stripe_rows: float = setting(
        0.0,
        'longest dark stripe in a lamp under a rolling shutter; 0 for a global shutter',
        unit='px',
        minimum=0.0,
        maximum=1000.0,
    )
    lamps_max: int = setting(
        64, 'at most so many lamps of an image are looked at, the brightest', minimum=1, maximum=1000
    )
