"""A survey from images to map: tasks that write to the checkpoint, and progress bars."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from tqdm import tqdm

from floor_localizer.core.arrays import Floats, Pixels
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.independent_tasks import Task, TaskRunner
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.floor_survey import ADJUSTMENTS, SurveyResult, adjust_survey
from floor_localizer.core.survey.submap import Submap, build_submap, select_keyframes, split_into_submaps
from floor_localizer.core.survey.submap_graph.connected_images import connect_images
from floor_localizer.core.survey.survey_image import SurveyImage, survey_image, view_outline
from floor_localizer.survey_files.checkpoint import Checkpoint, Detection
from floor_localizer.survey_files.survey_images import ImageBatch, PackedImages, pack_images
from floor_localizer.survey_files.survey_source import BagSource, FolderSource, SurveySource
from shirube_core.geometry import CameraMount

_MIN_DOTS = 8
IMAGES_PER_CHUNK = 40
_MIN_USABLE_FRACTION = 0.5  # smallest fraction of the images that must be usable


def detect_dots(checkpoint: Checkpoint, chunk: int, batch: ImageBatch, names: Sequence[str]) -> None:
    """Detect the dots of a chunk of images; their names are for messages."""
    detector = DotDetector()
    found: dict[int, Detection] = {}
    for (index, pixels), name in zip(batch, names, strict=True):
        found[index] = pixels if isinstance(pixels, str) else _detect_image(detector, pixels, name)
    checkpoint.save_dots(chunk, found)


def _detect_image(detector: DotDetector, pixels: Pixels, name: str) -> Detection:
    """Return the dots of an image, or a message that they are too few to match another image."""
    dots = detector.detect(pixels)
    if len(dots) < _MIN_DOTS:
        return f'{name}: shows {len(dots)} dots, at least {_MIN_DOTS} are needed'
    return dots


def build_span_submaps(
    checkpoint: Checkpoint, span: int, packed: PackedImages, first: int, position: Floats, settings: SurveySettings
) -> None:
    """Build the submaps of a span of images: one, or several where consecutive images do not match.

    Consecutive spans share an image; ``first`` is the index in the survey of the first image, ``position`` the optical
    centre in the base frame, shape (3,) [m].
    """
    images, submaps = list(packed), list[Submap]()
    begin, last, is_continuation = 0, len(images) - 1, span > 0
    while begin <= last:
        submap = build_submap(images, begin, last, position, settings, is_continuation=is_continuation)
        begin, is_continuation = int(submap.images[-1]) + 1, False
        submaps.append(replace(submap, images=submap.images + first))
    checkpoint.save_submaps(span, submaps)


@dataclass(frozen=True)
class SurveyRun:
    """A finished survey: its result, the usable images, and one-line messages about those that were not usable."""

    result: SurveyResult
    images: PackedImages
    faults: list[str]


def survey_inputs(
    source: FolderSource | BagSource, mount: CameraMount, settings: SurveySettings, existing: DotMap | None
) -> dict[str, object]:
    """Return everything besides the code that the results depend on, by human-readable names."""
    poses = [(frame.name, frame.T_odom_base.x, frame.T_odom_base.y, frame.T_odom_base.yaw) for frame in source.frames]
    files = [(path.name, (now := path.stat()).st_size, now.st_mtime_ns) for path in source.files]
    return {
        'images': _digest(repr(files).encode()),
        'odometry': _digest(repr(poses).encode()),
        'calibration': asdict(source.camera),
        'mount of the camera': [*mount.xyz, *mount.rpy],
        'settings': asdict(settings),
        'map to extend': None if existing is None else _digest(existing.points.tobytes()),
    }


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def run_survey(
    source: SurveySource,
    mount: CameraMount,
    settings: SurveySettings,
    checkpoint: Checkpoint,
    runner: TaskRunner,
    existing: DotMap | None = None,
) -> SurveyRun:
    """Make the map; finished steps are taken from the checkpoint, and the runner does not change the map.

    Raises:
        FloorLocalizerError: the images do not overlap, or too few can be used.
        OSError: a checkpoint cannot be written.
    """
    images, spans, faults = build_all_submaps(source, mount, settings, checkpoint, runner)
    outline, position = view_outline(source.camera, mount), np.array(mount.xyz)
    store = checkpoint.create_store()
    submaps = _iterate_submaps(checkpoint, spans)
    connected = connect_images(images, submaps, settings, store, existing, checkpoint)
    with tqdm(total=ADJUSTMENTS, desc='adjustments', disable=None) as bar:
        result = adjust_survey(
            images, connected, outline, position, settings, store, existing, runner, checkpoint,
            lambda done: bar.update(done - bar.n) and None,
        )  # fmt: skip
    return SurveyRun(result, images, faults)


def build_all_submaps(
    source: SurveySource, mount: CameraMount, settings: SurveySettings, checkpoint: Checkpoint, runner: TaskRunner
) -> tuple[PackedImages, int, list[str]]:
    """Detect dots and build submaps in parallel tasks.

    Returns:
        the usable images, the number of spans whose submaps are in the checkpoint, and one-line messages about the
        images that cannot be used.

    Raises:
        FloorLocalizerError: too few images can be used.
        OSError: a checkpoint cannot be written.
    """
    width = view_outline(source.camera, mount).width
    chosen = select_keyframes([frame.T_odom_base for frame in source.frames], width, settings)
    chunks = _detect_dots(source, chosen, checkpoint, runner)
    faults: list[str] = []
    images = pack_images(checkpoint.images_file, _usable_images(source, mount, checkpoint, chunks, faults))
    if len(faults) > (1.0 - _MIN_USABLE_FRACTION) * len(chosen):
        raise FloorLocalizerError(f'{len(faults)} of {len(chosen)} images cannot be used; the first: {faults[0]}')
    if len(images) < 2:
        raise FloorLocalizerError(
            f'{len(images)} image of the drive shows new floor, at least 2 are needed; drive farther'
        )
    spans = split_into_submaps([frame.T_odom_base for frame in images.frames], width, settings)
    tasks = [
        (checkpoint, number, images[first : last + 1], first, np.array(mount.xyz), settings)
        for number, (first, last) in enumerate(spans)
    ]
    _run_stage(runner, 'submaps', build_span_submaps, tasks, checkpoint.load_submaps)
    return images, len(spans), faults


def _iterate_submaps(checkpoint: Checkpoint, spans: int) -> Iterator[Submap]:
    """Yield all submaps with a progress bar."""
    for span in tqdm(range(spans), desc='pose graph', disable=None):
        yield from checkpoint.load_submaps(span) or ()


def _detect_dots(source: SurveySource, chosen: Sequence[int], checkpoint: Checkpoint, runner: TaskRunner) -> int:
    """Detect the dots of the keyframes; return the number of chunks in the checkpoint."""
    chunks = [chosen[start : start + IMAGES_PER_CHUNK] for start in range(0, len(chosen), IMAGES_PER_CHUNK)]
    tasks = [
        (checkpoint, number, source.batch(chunk), [source.frames[index].name for index in chunk])
        for number, chunk in enumerate(chunks)
    ]
    _run_stage(runner, f'dots of {IMAGES_PER_CHUNK} images', detect_dots, tasks, checkpoint.load_dots)
    return len(chunks)


def _usable_images(
    source: SurveySource, mount: CameraMount, checkpoint: Checkpoint, chunks: int, faults: list[str]
) -> Iterator[SurveyImage]:
    """Yield the usable images; messages about the others are appended to ``faults``."""
    for chunk in range(chunks):
        for index, dots in (checkpoint.load_dots(chunk) or {}).items():
            if isinstance(dots, str):
                faults.append(dots)
            else:
                frame = source.frames[index]
                yield survey_image(frame.name, frame.T_odom_base, dots, source.camera, mount)


def _run_stage(
    runner: TaskRunner,
    name: str,
    function: Task,
    tasks: Sequence[tuple[Any, ...]],
    load: Callable[[int], object | None],
) -> None:
    """Run the unfinished tasks of a stage; they write their results to the checkpoint."""
    missing = [number for number in range(len(tasks)) if load(number) is None]
    with tqdm(total=len(tasks), initial=len(tasks) - len(missing), desc=name, disable=None) as bar:
        for _ in runner.run(function, [tasks[number] for number in missing]):
            bar.update()
    lost_count = sum(load(number) is None for number in missing)
    if lost_count:
        raise FloorLocalizerError(
            f'{lost_count} results of the workers are missing in the checkpoint; '
            'use workers that see the same files under the same names'
        )
