"""Settings of the voxel map."""

from dataclasses import dataclass

from shirube_core.settings import setting, tunable

FREE_FRACTION = 0.5
"""A voxel is free below minus this fraction of log_odds_pass; higher values are decayed evidence."""


@tunable(
    'value_min',
    'hit_fraction_min',
    'log_odds_hit',
    'log_odds_pass',
    'log_odds_max',
    'log_odds_min',
    'log_odds_occupied',
    'half_life',
    'obstacle_memory',
)
@dataclass(frozen=True)
class VoxelSettings:
    """Size and extent of the voxels, and the rule of their values.

    See `VoxelMap` for the rules: ``count`` is eq. (3) of the paper, ``range_normalised`` removes its bias against far
    voxels, ``log_odds`` also clears the space in front of an obstacle.
    """

    rule: str = setting('log_odds', 'rule of the voxel values', choices=('count', 'range_normalised', 'log_odds'))
    resolution: float = setting(0.05, 'side of a voxel and of a map cell', 'm', (0.01, 1.0))
    height_min: float = setting(0.1, 'lowest height of obstacles', 'm', (-2.0, 5.0))
    height_max: float = setting(1.2, 'greatest height of obstacles', 'm', (-1.0, 6.0))
    range_min: float = setting(0.3, 'least distance of points; nearer ones are dropped', 'm', (0.0, 5.0))
    range_max: float = setting(
        5.0, 'greatest distance of obstacle points; rays of farther ones only clear space', 'm', (0.5, 50.0)
    )
    value_min: float = setting(
        0.05, 'least value of an obstacle with the rules count and range_normalised', limits=(0.001, 1.0)
    )
    hit_fraction_min: float = setting(
        0.05,
        'a voxel is hit if it has at least this fraction of the points of a surface across it (log_odds)',
        limits=(0.0, 1.0),
        former_name='hit_share_min',
    )
    log_odds_hit: float = setting(0.85, 'log-odds that a hit adds', limits=(0.01, 5.0))
    log_odds_pass: float = setting(0.4, 'log-odds that a ray through the voxel subtracts', limits=(0.01, 5.0))
    log_odds_max: float = setting(3.5, 'upper limit of the log-odds', limits=(0.5, 20.0))
    log_odds_min: float = setting(-2.0, 'lower limit of the log-odds', limits=(-20.0, -0.1))
    log_odds_occupied: float = setting(1.0, 'least value of an obstacle with the rule log_odds', limits=(0.01, 20.0))
    half_life: float = setting(
        300.0, 'half-life of the values of voxels that are not observed; cells of the map do not decay', 's', (1.0, 1e6)
    )
    obstacle_memory: float = setting(
        2.0,
        'time after which the part of an obstacle that is out of view is dropped, when rays cleared the rest of it; '
        'ten times as long where the floor was never seen free (log_odds)',
        's',
        (0.0, 1e6),
    )
    tiles_max: int = setting(
        2048, 'maximum number of tiles of 16 x 16 voxel columns; the nearest ones are kept', limits=(16, 1_000_000)
    )
