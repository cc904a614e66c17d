"""What the node says in the diagnostics: at which place the robot is, which targets are found, or why none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from time import monotonic

from shirube_ros.diagnostics import Level, Status
from stereo_landmark.core.landmark_fix import LandmarkFix
from stereo_landmark.core.pair.pair_localizer import LocatedPair
from stereo_landmark.core.procedure.sighting import TargetSighting

_LONGEST_SILENCE = 2.0
"""Without pairs the latest pose says nothing about now [s]."""


class LocalizerReport:
    """Remembers the latest pair and counts all of them."""

    def __init__(self, places_dir: str, now: Callable[[], float] = monotonic) -> None:
        """Start without pairs.

        Args:
            places_dir: the folder in use, for people.
            now: a clock that does not jump [s].
        """
        self._places_dir = places_dir
        self._now = now
        self._latest: LocatedPair | None = None
        self._latest_at = -float('inf')
        self._duration = 0.0
        self._fixes: Counter[str] = Counter()
        self._no_fixes: Counter[str] = Counter()

    def add(self, located: LocatedPair, duration: float) -> None:
        """Take what a pair told that was worked on for ``duration`` [s]."""
        self._latest, self._latest_at, self._duration = located, self._now(), duration
        if isinstance(located.answer, LandmarkFix):
            self._fixes[located.answer.place.name] += 1
        else:
            self._no_fixes[located.answer.reason] += 1

    def status(self) -> Status:
        """Return the state of now."""
        values = {'places': self._places_dir}
        values |= {f'pairs at {name}': str(number) for name, number in self._fixes.items()}
        values |= {f'pairs without: {reason}': str(number) for reason, number in self._no_fixes.items()}
        if self._latest is None:
            return Status(Level.WARN, 'no pair yet; check images and camera_info of left and right', values)
        answer = self._latest.answer
        values |= {'time for the latest pair [ms]': f'{1e3 * self._duration:.1f}'}
        if self._latest.lacks_tilt:
            values |= {'tilt': 'taken for level'}
        if self._now() - self._latest_at > _LONGEST_SILENCE:
            return Status(Level.WARN, 'pairs have stopped; check the cameras', values)
        if not isinstance(answer, LandmarkFix):
            return Status(Level.WARN, f'no fix: {answer.reason}', values | {'detail': answer.detail})
        if self._latest.lacks_tilt:
            why = 'taken for level: no reading of the imu is near the images; check both stamps'
            return Status(Level.WARN, f'at {answer.place.name}, {why}', values | _fix_values(answer))
        return Status(Level.OK, f'at {answer.place.name}', values | _fix_values(answer))


def _fix_values(fix: LandmarkFix) -> dict[str, str]:
    displacement = fix.displacement
    pose, sigmas = displacement.T_place_base, displacement.covariance.diagonal() ** 0.5
    found = [each.target for each in fix.sightings if isinstance(each, TargetSighting)]
    return {
        'targets found': ', '.join(found),
        'compared with the taught images': ', '.join(fix.compared) or 'nothing; measured by outlines',
        'points used': str(len(displacement.names)),
        'x, y, yaw': f'{pose.x:.4f} m, {pose.y:.4f} m, {pose.yaw:.4f} rad',
        'sigma x, y, yaw': f'{sigmas[0]:.4f} m, {sigmas[1]:.4f} m, {sigmas[3]:.4f} rad',
        'height of base_frame': f'{displacement.height:.4f} m',
    }
