"""Diagnostics of the node: whether there is a fix, its quality, or the reason for no fix."""

from collections import Counter
from collections.abc import Callable
from time import monotonic

from floor_localizer.core.fix import Fix, NoFix
from shirube_ros.diagnostics import Level, Status

_IMAGE_TIMEOUT = 2.0  # timeout of the images [s]


class LocalizerReport:
    """Stores the latest result and counts all results."""

    def __init__(self, map_name: str, now: Callable[[], float] = monotonic) -> None:
        """Start without results; ``now`` is a monotonic clock [s]."""
        self._map_name = map_name
        self._now = now
        self._latest: Fix | NoFix | None = None
        self._latest_at = -float('inf')
        self._duration = 0.0
        self._fixes = 0
        self._no_fixes: Counter[str] = Counter()

    def add(self, result: Fix | NoFix, duration: float) -> None:
        """Add the result of an image and its processing time [s]."""
        self._latest, self._latest_at, self._duration = result, self._now(), duration
        if isinstance(result, Fix):
            self._fixes += 1
        else:
            self._no_fixes[result.reason.value] += 1

    def status(self) -> Status:
        """Return the current status."""
        values = {'map': self._map_name, 'images with a fix': str(self._fixes)}
        for reason, number in self._no_fixes.items():
            values[f'images without: {reason}'] = str(number)
        if self._latest is None:
            return Status(Level.WARN, 'no image received; check the topics image_raw and camera_info', values)
        values['time for the latest image [ms]'] = f'{1e3 * self._duration:.1f}'
        if self._now() - self._latest_at > _IMAGE_TIMEOUT:
            return Status(Level.WARN, 'no images for 2 s; check the camera', values)
        if isinstance(self._latest, NoFix):
            values |= _no_fix_values(self._latest)
            return Status(Level.WARN, f'no fix: {self._latest.reason.value}', values)
        return Status(Level.OK, 'fix', values | _fix_values(self._latest))


def _no_fix_values(result: NoFix) -> dict[str, str]:
    dots = 0 if result.dots is None else len(result.dots)
    return {'detail': result.detail, 'dots': str(dots)}


def _fix_values(fix: Fix) -> dict[str, str]:
    pose = fix.T_map_base
    sigma_x, sigma_y, sigma_yaw = fix.covariance.diagonal() ** 0.5
    level = {'level': fix.level} if fix.level else {}
    return level | {
        'dots': str(len(fix.dots)),
        'dots matched': str(int(fix.matched.sum())),
        'match rate': f'{fix.match_rate:.3f}',
        'expected chance alignments': f'{fix.expected_chance_alignments:.1e}',
        'searched with a prior': 'yes' if fix.used_prior else 'no',
        'x, y, yaw': f'{pose.x:.4f} m, {pose.y:.4f} m, {pose.yaw:.4f} rad',
        'sigma x, y, yaw': f'{1e3 * sigma_x:.3f} mm, {1e3 * sigma_y:.3f} mm, {1e3 * sigma_yaw:.3f} mrad',
        'camera height over nominal': f'{100.0 * fix.scale:+.2f} %',
        'tilt': f'{1e3 * fix.tilt[0]:.2f} mrad, {1e3 * fix.tilt[1]:.2f} mrad',
    }
