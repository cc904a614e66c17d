"""When a pose is believed, and how large the map may grow."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class MappingSettings:
    """Poses for frames, and the size of the global map."""

    pose_wait: float = setting(
        0.5, 'a frame waits this long for its pose, then it is dropped', unit='s', minimum=0.0, maximum=10.0
    )
    pose_gap_max: float = setting(
        0.5,
        'between poses that lie farther apart in time none is guessed',
        unit='s',
        minimum=0.01,
        maximum=10.0,
    )
    speed_max: float = setting(
        3.0, 'a pose that asks for more speed has jumped', unit='m/s', minimum=0.01, maximum=50.0
    )
    turn_rate_max: float = setting(
        6.0, 'a pose that asks for a faster turn has jumped', unit='rad/s', minimum=0.01, maximum=100.0
    )
    settle_time: float = setting(
        1.0,
        'poses after a jump are believed once they agree for so long',
        unit='s',
        minimum=0.0,
        maximum=60.0,
    )
    cells_max: int = setting(
        16_000_000,
        'the map keeps so many cells, routes are sought on so many; one that is larger is refused',
        minimum=1_000_000,
        maximum=32_000_000,  # lengths of routes through more do not fit into the keys of the incremental search
    )
