"""One pose from several localizers and odometry."""

from collections.abc import Mapping, Sequence

from numpy.typing import ArrayLike

from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from shirube.inputs import InputError, as_numbers
from shirube.results import FusedResult
from shirube_core.geometry import SE2
from shirube_core.settings import check_settings


def fuse(
    poses: Mapping[str, ArrayLike], odometry: ArrayLike = (), *, sigmas: Mapping[str, Sequence[float]] | None = None
) -> FusedResult:
    """Fuse poses and odometry; return the pose at the last stamp, or the reason for none.

    Args:
        poses: rows of each source: stamp [s], x, y [m], yaw [rad] in the map.
        odometry: rows of stamp [s], x, y [m], yaw [rad] in the odometry frame.
        sigmas: standard deviations of each source, of x and y [m] and of yaw [rad]; else the node's defaults.

    Raises:
        InputError, SettingsError: an argument that cannot be used.
    """
    if not poses:
        raise InputError('there is no source of poses; give one or more')
    if unknown := set(sigmas or {}) - set(poses):
        raise InputError(f'sigmas has {", ".join(sorted(unknown))}, which poses has not; use the same names')
    tables = {name: _table(name, rows) for name, rows in poses.items()}
    driven = _table('odometry', odometry)
    stamps = [row[0] for rows in (*tables.values(), driven) for row in rows]
    if not stamps:
        raise InputError('there is no pose and no odometry; give rows of stamp, x, y, yaw')
    sources = [_settings(name, (sigmas or {}).get(name)) for name in tables]
    arbiter = Arbiter(sources, ArbiterSettings())
    events = [(row, number) for number, rows in enumerate(tables.values()) for row in rows]
    # The zero of the stamps does not matter, but a stamp of 0 is invalid.
    for (stamp, *pose), source in sorted([*events, *((row, None) for row in driven)], key=lambda each: each[0][0]):
        now = _nanoseconds(stamp - min(stamps))
        fault = (
            arbiter.add_odometry(now, SE2(*pose), now)
            if source is None
            else arbiter.add_pose(source, now, SE2(*pose), None, now)
        )
        if fault is not None:
            name = 'odometry' if source is None else list(tables)[source]
            raise InputError(f'{name} at {stamp:g} s: {fault.value}; remove or correct this row')
    counts: dict[str, dict[str, int]] = {name: {} for name in tables}
    for (source, status), number in arbiter.counts().items():
        counts[list(tables)[source]][status.value] = number
    estimate = arbiter.estimate_at(_nanoseconds(max(stamps) - min(stamps)))
    if estimate is None:
        reasons = sorted({status for of_source in counts.values() for status in of_source})
        return FusedResult(reason=', '.join(reasons) or 'no source has a pose', counts=counts)
    return FusedResult((estimate.x, estimate.y, estimate.yaw), estimate.P[:3, :3].copy(), counts=counts)


def _nanoseconds(seconds: float) -> int:
    return 1_000_000_000 + round(1e9 * seconds)


def _table(name: str, rows: ArrayLike) -> list[list[float]]:
    is_empty = isinstance(rows, Sequence) and not rows
    return [] if is_empty else list(as_numbers(name, rows, (None, 4)).tolist())


def _settings(name: str, sigmas: Sequence[float] | None) -> SourceSettings:
    if sigmas is None:
        return SourceSettings()
    xy, yaw = as_numbers(f'sigmas of {name}', sigmas, (2,)).tolist()
    settings = SourceSettings(sigma_xy=xy, sigma_yaw=yaw)
    check_settings(settings)
    return settings
