"""Settings of pose checks and map size."""

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class MappingSettings:
    """Pose lookup, jump detection and maximum size of the global map."""

    pose_wait: float = setting(0.5, 'time after which a frame without a pose is dropped', 's', (0.0, 10.0))
    pose_gap_max: float = setting(0.5, 'largest gap between two poses that is interpolated', 's', (0.01, 10.0))
    speed_max: float = setting(3.0, 'a pose has jumped if it implies a higher speed', 'm/s', (0.01, 50.0))
    turn_rate_max: float = setting(6.0, 'a pose has jumped if it implies a higher turn rate', 'rad/s', (0.01, 100.0))
    settle_time: float = setting(
        1.0, 'poses after a jump are accepted once they have been consistent for this time', 's', (0.0, 60.0)
    )
    cells_max: int = setting(
        16_000_000,
        'maximum number of cells of the map and of a costmap; larger maps are rejected',
        limits=(1_000_000, 32_000_000),  # longer routes do not fit into the keys of D* Lite
    )
