"""How points become voxels, and what counts as an obstacle."""

from __future__ import annotations

from dataclasses import dataclass

from reward_planner.core.voxels.voxel_error import VoxelError
from shirube_settings import setting

FREE_SHARE = 0.5
"""Of what a ray takes, a voxel must have lost so much to be free; less has faded."""


@dataclass(frozen=True)
class VoxelSettings:
    """Size of the voxels, the space they fill, and the rule that gives them a value.

    The rules are those of `VoxelMap`: ``count`` is eq. (3) of the paper, ``range_normalised`` the same without its
    bias against far voxels, ``log_odds`` adds that rays find the space in front of an obstacle free.
    """

    rule: str = setting(
        'log_odds',
        'what the value of a voxel is made of',
        choices=('count', 'range_normalised', 'log_odds'),
    )
    resolution: float = setting(
        0.05, 'side of a voxel and of a map cell', unit='m', minimum=0.01, maximum=1.0
    )
    height_min: float = setting(
        0.1, 'what is lower does not hinder the robot', unit='m', minimum=-2.0, maximum=5.0
    )
    height_max: float = setting(1.2, 'what is higher neither', unit='m', minimum=-1.0, maximum=6.0)
    range_min: float = setting(0.3, 'nearer points are dropped', unit='m', minimum=0.0, maximum=5.0)
    range_max: float = setting(
        5.0, 'farther points only tell what is free before them', unit='m', minimum=0.5, maximum=50.0
    )
    value_min: float = setting(
        0.2, 'obstacles have this value at least under count and range_normalised', minimum=0.001, maximum=1.0
    )
    hit_share_min: float = setting(
        0.05,
        'a voxel is hit in a frame by this share at least of the points that would fill it (log_odds)',
        minimum=0.0,
        maximum=1.0,
    )
    log_odds_hit: float = setting(0.85, 'what a hit adds', minimum=0.01, maximum=5.0)
    log_odds_pass: float = setting(0.4, 'what a ray through the voxel takes away', minimum=0.01, maximum=5.0)
    log_odds_max: float = setting(3.5, 'no voxel is believed occupied more firmly', minimum=0.5, maximum=20.0)
    log_odds_min: float = setting(-2.0, 'no voxel is believed free more firmly', minimum=-20.0, maximum=-0.1)
    log_odds_occupied: float = setting(
        1.0, 'obstacles have this value at least under log_odds', minimum=0.01, maximum=20.0
    )
    half_life: float = setting(
        300.0,
        'after this time half of the value of voxels that are no longer seen is forgotten; cells of the map stay',
        unit='s',
        minimum=1.0,
        maximum=1e6,
    )
    tiles_max: int = setting(
        2048, 'so many tiles of 16 x 16 voxels are kept, the nearest ones', minimum=16, maximum=1_000_000
    )


def refuse_contradictions(settings: VoxelSettings) -> None:
    """Refuse settings under which no voxel could ever be occupied, or none free.

    A voxel that is hit in every frame is never passed, so hits need no relation to passes: it climbs to log_odds_max,
    which must be that of an obstacle; one that is only passed sinks to log_odds_min, which must be that of free space.

    Raises:
        VoxelError: names the two settings.
    """
    s = settings
    taken = FREE_SHARE * s.log_odds_pass
    for low, high, what, is_wrong in (
        ('height_min', 'height_max', 'must be lower', s.height_min >= s.height_max),
        ('range_min', 'range_max', 'must be less', s.range_min >= s.range_max),
        ('log_odds_occupied', 'log_odds_max', 'may not be more', s.log_odds_occupied > s.log_odds_max),
        ('log_odds_min', 'log_odds_pass', f'must be {-taken:g} or less', -s.log_odds_min < taken),
    ):
        if is_wrong:
            raise VoxelError(
                f'{low} is {getattr(s, low):g}, it {what}; {high} is {getattr(s, high):g}, change one of them'
            )
