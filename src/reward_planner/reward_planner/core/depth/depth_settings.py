"""How pixels of two or three cameras are matched."""

from __future__ import annotations

from dataclasses import dataclass

from reward_planner.core.depth.depth_error import DepthError
from shirube_settings import setting


@dataclass(frozen=True)
class DepthSettings:
    """Matching by OpenCV, and what is made of two pairs."""

    matcher: str = setting(
        'sgbm',
        'sgbm: semi-global in three directions; bm: blocks, three times as fast, with large gaps',
        choices=('sgbm', 'bm'),
    )
    disparities: int = setting(
        64, 'largest disparity, a multiple of 16; what is nearer is lost', unit='px', minimum=16, maximum=512
    )
    block: int = setting(3, 'side of a block that is compared, odd', unit='px', minimum=3, maximum=31)
    uniqueness: int = setting(
        10, 'the best match must be better than others by so much', unit='%', minimum=0, maximum=99
    )
    speckle: int = setting(
        60, 'smaller islands of depth are dropped, 0 keeps them', unit='px', minimum=0, maximum=10_000
    )
    fusion: str = setting(
        'union',
        'of two pairs: agreement keeps what both see alike, union also what only one sees; contradictions never',
        choices=('union', 'agreement'),
    )
    agreement: float = setting(
        1.0, 'two pairs agree if their disparities differ by no more', unit='px', minimum=0.1, maximum=10.0
    )


def refuse_unmatchable(settings: DepthSettings) -> None:
    """Refuse settings that OpenCV has no matcher for.

    Raises:
        DepthError: disparities that are no multiple of 16, or an even block.
    """
    if settings.disparities % 16 or settings.block % 2 == 0:
        raise DepthError(
            f'disparities is {settings.disparities} and block {settings.block}; '
            'give a multiple of 16 and an odd number'
        )
