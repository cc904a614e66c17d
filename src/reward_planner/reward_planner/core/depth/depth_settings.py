"""Settings of stereo matching."""

from dataclasses import dataclass

from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.settings import setting


@dataclass(frozen=True)
class DepthSettings:
    """OpenCV's stereo matchers, and the fusion of two pairs."""

    matcher: str = setting(
        'sgbm',
        'sgbm: semi-global matching in three directions; bm: block matching, three times as fast, with large gaps',
        choices=('sgbm', 'bm'),
    )
    disparities: int = setting(64, 'largest disparity, a multiple of 16; nearer points are lost', 'px', (16, 512))
    block: int = setting(3, 'side of a matched block, odd', 'px', (3, 31))
    uniqueness: int = setting(10, 'uniqueness ratio: margin of the best match over others', '%', (0, 99))
    speckle: int = setting(60, 'speckle filter: smaller islands of depth are dropped, 0 disables it', 'px', (0, 10_000))
    fusion: str = setting(
        'union',
        'agreement keeps depths that both pairs confirm, union also those of one pair; inconsistent ones are dropped',
        choices=('union', 'agreement'),
    )
    agreement: float = setting(1.0, 'largest difference of disparities at which two pairs agree', 'px', (0.1, 10.0))


def check_matcher_settings(settings: DepthSettings) -> None:
    """Raise a RewardPlannerError for settings that OpenCV's matchers reject."""
    if settings.disparities % 16 or settings.block % 2 == 0:
        raise RewardPlannerError(
            f'disparities is {settings.disparities} and block {settings.block}; give a multiple of 16 and an odd number'
        )
