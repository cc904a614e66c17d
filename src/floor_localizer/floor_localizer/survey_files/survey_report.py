"""Report and tables of a survey."""

import math
from pathlib import Path

import numpy as np

from floor_localizer.core.arrays import Floats
from floor_localizer.core.survey.floor_survey import SurveyResult
from floor_localizer.survey_files.survey_run import SurveyRun
from shirube_core.files import atomic_write, write_csv

_BIN_WIDTH = 1e-8  # finer than the reported digits of a residual [m]
_MAX_LISTED = 10


class LengthHistogram:
    """Histogram of lengths with bins of 10 nm, their rms and maximum."""

    def __init__(self) -> None:
        """Begin empty."""
        self._counts = np.zeros(1, dtype=np.int64)
        self._squares, self.maximum = 0.0, 0.0

    @property
    def count(self) -> int:
        """Number of lengths."""
        return int(self._counts.sum())

    @property
    def rms(self) -> float:
        """Root mean square of the lengths [m]."""
        return math.sqrt(self._squares / max(self.count, 1))

    def add(self, lengths: Floats) -> None:
        """Add lengths, shape (n,) [m]."""
        counts = np.bincount((lengths / _BIN_WIDTH).astype(np.int64), minlength=len(self._counts))
        counts[: len(self._counts)] += self._counts
        self._counts = counts
        self._squares += float(np.sum(lengths**2))
        self.maximum = max(self.maximum, float(lengths.max(initial=0.0)))

    def quantile(self, fraction: float) -> float:
        """Return a quantile of the lengths [m]."""
        return _BIN_WIDTH * float(np.searchsorted(np.cumsum(self._counts), fraction * self.count))


def survey_report(run: SurveyRun, scale: float | None) -> str:
    """Return the statistics of a survey as text, with the scale factor from the known length, if there is one."""
    result = run.result
    lengths = LengthHistogram()
    for _, residuals in result.residuals:
        lengths.add(np.hypot(*residuals.T))
    counts = result.counts[result.existing_count :]
    suspension = 100.0 * result.states[:, 3], np.degrees(result.states[:, 4]), np.degrees(result.states[:, 5])
    scale_text = 'from the height of the camera'
    if scale is not None:
        scale_text = f'from the known length, {100.0 * (scale - 1.0):+.3f} %'
    residual_text = f'{1e3 * lengths.rms / math.sqrt(2.0):.4f} mm rms per axis'
    residual_text += f', {1e3 * lengths.quantile(0.95):.4f} mm for 95 %, {1e3 * lengths.maximum:.3f} mm max'
    camera = f'height {suspension[0].mean():+.2f} % ± {suspension[0].std():.2f} %'
    for name, angles in (('roll', suspension[1]), ('pitch', suspension[2])):
        camera += f', {name} {angles.mean():+.2f}° ± {angles.std():.2f}°'
    rows = [
        ('images', f'{len(result.images)} of {len(run.images)} are on the map, {len(run.faults)} could not be used'),
        (
            'dots',
            f'{len(result.dot_map)}, {len(counts)} of them new; {result.spurious_count} more were dropped as spurious',
        ),
        ('observed', f'{lengths.count} times, {np.mean(counts) if len(counts) else 0.0:.1f} per new dot'),
        ('loops', f'{result.loop_closures} loop closures between submaps that are not consecutive'),
        ('residuals', residual_text),
        ('camera', f'{camera} relative to the mount'),
        ('scale', scale_text),
    ]
    lines = [f'{name:<12}{text}' for name, text in rows]
    if len(result.unconnected):
        names = [run.images.frames[index].name for index in result.unconnected[:_MAX_LISTED]]
        more = ' ...' if len(result.unconnected) > _MAX_LISTED else ''
        lines.append(f'not connected to the map: {", ".join(names)}{more}')
    lines += [f'could not be used: {fault}' for fault in run.faults[:_MAX_LISTED]]
    return '\n'.join(lines)


def save_observation_counts(path: Path, result: SurveyResult) -> None:
    """Write each dot with the number of images that observed it; raises `OSError`."""
    dots = result.dot_map
    with atomic_write(path) as file:
        file.write(b'x,y,diameter,count\n')
        for (x, y), diameter, count in zip(dots.points, dots.diameters, result.counts, strict=True):
            size = '' if math.isnan(diameter) else f'{diameter:.6f}'
            file.write(f'{x:.6f},{y:.6f},{size},{count}\n'.encode())


def save_image_poses(path: Path, run: SurveyRun) -> None:
    """Write the state of each image on the map; raises `OSError`."""
    states = zip(run.result.images.tolist(), run.result.states.tolist(), strict=True)
    rows = ([run.images.frames[index].name, *(f'{value:.7f}' for value in state)] for index, state in states)
    write_csv(path, ('image', 'x', 'y', 'yaw', 'scale', 'roll', 'pitch'), rows)
