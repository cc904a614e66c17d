"""Report and tables of a survey."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import numpy as np

from floor_localizer.core.survey.floor_survey import SurveyResult
from floor_localizer.survey_files.residual_statistics import LengthCounter
from floor_localizer.survey_files.survey_run import SurveyRun
from shirube_files import write_text, written_beside

_MOST_LISTED = 10


def survey_report(run: SurveyRun, scale: float | None) -> str:
    """Return the statistics of a survey as text.

    Args:
        run: the survey.
        scale: scale factor from the known length, None without one.
    """
    result = run.result
    lengths = LengthCounter()
    for _, residuals in result.residuals:
        lengths.add(np.hypot(*residuals.T))
    counts = result.counts[result.existing_count :]
    sway = 100.0 * result.states[:, 3], np.degrees(result.states[:, 4]), np.degrees(result.states[:, 5])
    scale_text = 'from the height of the camera'
    if scale is not None:
        scale_text = f'from the known length, {100.0 * (scale - 1.0):+.3f} %'
    left_over = f'{1e3 * lengths.rms / math.sqrt(2.0):.4f} mm rms per axis'
    left_over += f', {1e3 * lengths.below(0.95):.4f} mm for 95 %, {1e3 * lengths.most:.3f} mm max'
    camera = f'height {sway[0].mean():+.2f} % ± {sway[0].std():.2f} %'
    for name, angles in (('roll', sway[1]), ('pitch', sway[2])):
        camera += f', {name} {angles.mean():+.2f}° ± {angles.std():.2f}°'
    rows = [
        (
            'images',
            f'{len(result.images)} of {len(run.images)} are on the map, {len(run.faults)} could not be used',
        ),
        (
            'dots',
            f'{len(result.dot_map)}, {len(counts)} of them new; {result.dirt} more were dropped as spurious',
        ),
        ('observed', f'{lengths.number} times, {np.mean(counts) if len(counts) else 0.0:.1f} per new dot'),
        ('loops', f'{result.loops} loop closures between submaps that are not consecutive'),
        ('residuals', left_over),
        ('camera', f'{camera} relative to the mount'),
        ('scale', scale_text),
    ]
    lines = [f'{name:<12}{text}' for name, text in rows]
    if len(result.left_out):
        names = [run.images.frames[index].name for index in result.left_out[:_MOST_LISTED]]
        more = ' ...' if len(result.left_out) > _MOST_LISTED else ''
        lines.append(f'not connected to the map: {", ".join(names)}{more}')
    lines += [f'could not be used: {fault}' for fault in run.faults[:_MOST_LISTED]]
    return '\n'.join(lines)


def save_sightings(path: Path, result: SurveyResult) -> None:
    """Write each dot with the number of images that observed it.

    Raises:
        OSError: the file cannot be written.
    """
    dots = result.dot_map
    with written_beside(path) as file:
        file.write(b'x,y,diameter,count\n')
        for (x, y), diameter, count in zip(dots.points, dots.diameters, result.counts, strict=True):
            size = '' if math.isnan(diameter) else f'{diameter:.6f}'
            file.write(f'{x:.6f},{y:.6f},{size},{count}\n'.encode())


def save_image_poses(path: Path, run: SurveyRun) -> None:
    """Write the state of each image on the map.

    Raises:
        OSError: the file cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator='\n')
    table.writerow(('image', 'x', 'y', 'yaw', 'scale', 'roll', 'pitch'))
    for index, state in zip(run.result.images.tolist(), run.result.states.tolist(), strict=True):
        table.writerow([run.images.frames[index].name, *(f'{value:.7f}' for value in state)])
    write_text(path, text.getvalue())
