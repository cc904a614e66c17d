"""Diagnostics of the node: the present place, the detected targets, or the reason why there is no fix."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from time import monotonic

from shirube_ros.diagnostics import Level, Status
from stereo_landmark.core.landmark_fix import LandmarkFix
from stereo_landmark.core.pair.pair_localizer import LocatedPair
from stereo_landmark.core.procedure.target_detection import TargetDetection

_PAIR_TIMEOUT = 2.0
"""A pose is stale when no image pair was received for this time [s]."""


class LocalizerReport:
    """Keeps the latest result and counts the results by place and failure reason."""

    def __init__(self, places_dir: str, now: Callable[[], float] = monotonic) -> None:
        """Start without results.

        Args:
            places_dir: folder of the taught places, for display.
            now: monotonic clock [s].
        """
        self._places_dir = places_dir
        self._now = now
        self._latest: LocatedPair | None = None
        self._latest_at = -float('inf')
        self._duration = 0.0
        self._fixes: Counter[str] = Counter()
        self._no_fixes: Counter[str] = Counter()

    def add(self, located: LocatedPair, duration: float) -> None:
        """Add the result of a pair.

        Args:
            located: localization result.
            duration: processing time [s].
        """
        self._latest, self._latest_at, self._duration = located, self._now(), duration
        if isinstance(located.result, LandmarkFix):
            self._fixes[located.result.place.name] += 1
        else:
            self._no_fixes[located.result.reason] += 1

    def status(self) -> Status:
        """Return the present diagnostic status."""
        values = {'places': self._places_dir}
        values |= {f'pairs at {name}': str(number) for name, number in self._fixes.items()}
        values |= {f'pairs without: {reason}': str(number) for reason, number in self._no_fixes.items()}
        if self._latest is None:
            return Status(Level.WARN, 'no image pair received; check both images and camera_info', values)
        result = self._latest.result
        values |= {'processing time [ms]': f'{1e3 * self._duration:.1f}'}
        if self._latest.is_tilt_missing:
            values |= {'tilt': 'assumed level'}
        if self._now() - self._latest_at > _PAIR_TIMEOUT:
            return Status(Level.WARN, 'image pairs timed out; check the cameras', values)
        if not isinstance(result, LandmarkFix):
            return Status(Level.WARN, f'no fix: {result.reason}', values | {'detail': result.detail})
        if self._latest.is_tilt_missing:
            why = 'assumed level: no IMU reading near the stamp of the images; check the stamps of both'
            return Status(Level.WARN, f'at {result.place.name}, {why}', values | _fix_values(result))
        return Status(Level.OK, f'at {result.place.name}', values | _fix_values(result))


def _fix_values(fix: LandmarkFix) -> dict[str, str]:
    displacement = fix.displacement
    pose, sigmas = displacement.T_place_base, displacement.covariance.diagonal() ** 0.5
    found = [each.target for each in fix.detections if isinstance(each, TargetDetection)]
    return {
        'targets found': ', '.join(found),
        'measured by patches': ', '.join(fix.matched_patches) or 'none; measured by outlines',
        'points used': str(len(displacement.names)),
        'x, y, yaw': f'{pose.x:.4f} m, {pose.y:.4f} m, {pose.yaw:.4f} rad',
        'sigma x, y, yaw': f'{sigmas[0]:.4f} m, {sigmas[1]:.4f} m, {sigmas[3]:.4f} rad',
        'height of base_frame': f'{displacement.height:.4f} m',
    }
