"""Settings of the lamp detector."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class LampSettings:
    """Lamp detection in an image."""

    contrast_min: float = setting(
        5.0, 'minimum contrast of a lamp above its background, in grey levels', minimum=2.0, maximum=200.0
    )
    noise_sigmas: float = setting(
        4.0, 'minimum contrast of a lamp in standard deviations of the noise', minimum=1.0, maximum=20.0
    )
    diameter_min: float = setting(
        4.0,
        'minimum diameter of a tracked lamp; ufsook is decoded from 6, rs_fsk from 12 to 16 at a row_time of 18.9 us, '
        'manchester from 320',
        unit='px',
        minimum=2.0,
        maximum=1000.0,
    )
    diameter_max: float = setting(
        120.0,
        'maximum lamp diameter; manchester needs lamps of 320 or more at a row_time of 18.9 us, so set 450, but '
        'windows and ceiling lights of that size are then processed too',
        unit='px',
        minimum=4.0,
        maximum=4000.0,
    )
    roundness_min: float = setting(
        0.4, 'minimum width over length of a lamp, one half of which may be dark', minimum=0.0, maximum=1.0
    )
    stripe_rows: float = setting(
        0.0,
        'maximum height of a dark band in a lamp under a rolling shutter; 0 to derive it from the light codes',
        unit='px',
        minimum=0.0,
        maximum=1000.0,
    )
    lamps_max: int = setting(
        64, 'maximum number of lamp candidates per image; the brightest are used', minimum=1, maximum=1000
    )
