"""A survey from its images to the map, with checkpoints and progress."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.floor_survey import SurveyResult, survey_floor
from floor_localizer.core.survey.piece import Piece
from floor_localizer.core.survey.survey_image import SurveyImage, survey_image, view_outline
from floor_localizer.core.survey.survey_plan import choose_images, cut_pieces
from floor_localizer.core.survey.survey_settings import SurveySettings
from floor_localizer.survey_files.checkpoint import Checkpoint, Found
from floor_localizer.survey_files.survey_source import SurveySource
from floor_localizer.survey_files.survey_tasks import find_dots, put_together
from floor_localizer.task_runner import Task, TaskRunner
from shirube_geometry import CameraMount

Part = TypeVar('Part')

_CHUNK = 40
_USABLE = 0.5
"""Of the images, at least."""


@dataclass(frozen=True)
class SurveyRun:
    """What came of a survey.

    Attributes:
        result: the map and all poses.
        images: that were looked at.
        faults: lines about images that could not be used.
    """

    result: SurveyResult
    images: list[SurveyImage]
    faults: list[str]


def survey_key(
    source: SurveySource, name: str, mount: CameraMount, settings: SurveySettings, existing: DotMap | None
) -> dict[str, object]:
    """Return everything that the results of a survey depend on."""
    poses = [
        (frame.name, frame.T_odom_base.x, frame.T_odom_base.y, frame.T_odom_base.yaw)
        for frame in source.frames
    ]
    return {
        'source': name,
        'frames': hashlib.sha256(repr(poses).encode()).hexdigest(),
        'camera': asdict(source.camera),
        'mount': [*mount.xyz, *mount.rpy],
        'settings': asdict(settings),
        'extends': None if existing is None else hashlib.sha256(existing.points.tobytes()).hexdigest(),
    }


def run_survey(
    source: SurveySource,
    mount: CameraMount,
    settings: SurveySettings,
    checkpoint: Checkpoint,
    runner: TaskRunner,
    existing: DotMap | None = None,
) -> SurveyRun:
    """Make the map; what a checkpoint holds is not done again, and it is the same whatever the tasks run on.

    Raises:
        FloorLocalizerError: images that do not overlap, or too few that can be used.
        OSError: a checkpoint cannot be written.
    """
    outline = view_outline(source.camera, mount)
    frames = source.frames
    chosen = choose_images([frame.T_odom_base for frame in frames], outline.width, settings)
    found = _detect(source, chosen, checkpoint, runner)
    faults = [dots for dots in found.values() if isinstance(dots, str)]
    if len(faults) > (1.0 - _USABLE) * len(found):
        raise FloorLocalizerError(
            f'{len(faults)} of {len(found)} images cannot be used; the first: {faults[0]}'
        )
    images = [
        survey_image(frames[index].name, frames[index].T_odom_base, dots, source.camera, mount)
        for index, dots in found.items()
        if not isinstance(dots, str)
    ]
    if len(images) < 2:
        raise FloorLocalizerError(
            f'{len(images)} image of the drive shows new floor, at least 2 are needed; drive on'
        )
    position = np.array(mount.xyz)
    pieces = _put_together(images, outline.width, position, settings, checkpoint, runner)
    with tqdm(total=len(pieces) + 3, desc='map', unit='step', disable=None) as bar:
        result = survey_floor(
            images, pieces, outline, position, settings, existing, progress=lambda _: bar.update() and None
        )
    return SurveyRun(result, images, faults)


def _detect(
    source: SurveySource, chosen: Sequence[int], checkpoint: Checkpoint, runner: TaskRunner
) -> dict[int, Found]:
    """Find the dots of the chosen images."""
    chunks = [chosen[start : start + _CHUNK] for start in range(0, len(chosen), _CHUNK)]
    tasks = [
        (checkpoint, number, source.part(chunk), [source.frames[index].name for index in chunk])
        for number, chunk in enumerate(chunks)
    ]
    parts = _stage(runner, f'dots of {_CHUNK} images', find_dots, tasks, checkpoint.load_dots)
    return {index: dots for part in parts for index, dots in part.items()}


def _put_together(
    images: Sequence[SurveyImage],
    view_width: float,
    position: NDArray[np.float64],
    settings: SurveySettings,
    checkpoint: Checkpoint,
    runner: TaskRunner,
) -> list[Piece]:
    """Put the images of each span together to pieces."""
    spans = cut_pieces([image.T_odom_base for image in images], view_width, settings)
    tasks = [
        (checkpoint, number, images[first : last + 1], first, position, settings)
        for number, (first, last) in enumerate(spans)
    ]
    return [
        piece
        for part in _stage(runner, 'pieces', put_together, tasks, checkpoint.load_pieces)
        for piece in part
    ]


def _stage(
    runner: TaskRunner,
    name: str,
    function: Task,
    tasks: Sequence[tuple[Any, ...]],
    load: Callable[[int], Part | None],
) -> list[Part]:
    """Run the tasks of a stage that are not done yet, and return what all of them left in the checkpoint."""
    missing = [task for number, task in enumerate(tasks) if load(number) is None]
    with tqdm(total=len(tasks), initial=len(tasks) - len(missing), desc=name, disable=None) as bar:
        for _ in runner.run(function, missing):
            bar.update()
    parts = [part for number in range(len(tasks)) if (part := load(number)) is not None]
    if len(parts) < len(tasks):
        raise FloorLocalizerError(
            f'{len(tasks) - len(parts)} parts of what the workers found are not in the checkpoint; '
            'use workers that see the same files under the same names'
        )
    return parts
