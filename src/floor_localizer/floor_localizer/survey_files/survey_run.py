"""A survey from its images to the map, with checkpoints and progress."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from floor_localizer.core.dot_extraction import DotDetector
from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.floor_survey import SurveyResult, survey_floor
from floor_localizer.core.survey.piece import Piece, build_piece
from floor_localizer.core.survey.survey_image import SurveyImage, survey_image, view_outline
from floor_localizer.core.survey.survey_plan import choose_images, cut_pieces
from floor_localizer.core.survey.survey_settings import SurveySettings
from floor_localizer.survey_files.checkpoint import Checkpoint, Found
from floor_localizer.survey_files.survey_source import SurveySource
from shirube_geometry import CameraMount

_CHUNK = 40
_LEAST_DOTS = 8
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
    existing: DotMap | None = None,
) -> SurveyRun:
    """Make the map; what a checkpoint holds is not done again.

    Raises:
        FloorLocalizerError: images that do not overlap, or too few that can be used.
        OSError: a checkpoint cannot be written.
    """
    outline = view_outline(source.camera, mount)
    frames = source.frames
    chosen = choose_images([frame.T_odom_base for frame in frames], outline.width, settings)
    found = _detect(source, chosen, checkpoint)
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
    pieces = _put_together(images, outline.width, position, settings, checkpoint)
    with tqdm(total=len(pieces) + 3, desc='map', unit='step', disable=None) as bar:
        result = survey_floor(
            images, pieces, outline, position, settings, existing, progress=lambda _: bar.update() and None
        )
    return SurveyRun(result, images, faults)


def _detect(source: SurveySource, chosen: Sequence[int], checkpoint: Checkpoint) -> dict[int, Found]:
    """Find the dots of the chosen images."""
    chunks = [chosen[start : start + _CHUNK] for start in range(0, len(chosen), _CHUNK)]
    known = {number: checkpoint.load_dots(number) for number in range(len(chunks))}
    detector, waiting = DotDetector(), [number for number, dots in known.items() if dots is None]
    missing = [index for number in waiting for index in chunks[number]]
    collected: dict[int, Found] = {}
    for index, pixels in tqdm(
        source.read(missing), desc='dots', total=len(missing), unit='image', disable=None
    ):
        collected[index] = (
            pixels if isinstance(pixels, str) else _dots_of(detector, pixels, source.frames[index].name)
        )
        if index == chunks[waiting[0]][-1]:
            number = waiting.pop(0)
            known[number] = collected
            checkpoint.save_dots(number, collected)
            collected = {}
    return {index: dots for part in known.values() if part is not None for index, dots in part.items()}


def _dots_of(detector: DotDetector, pixels: NDArray[np.uint8], name: str) -> Found:
    """Return the dots of an image, or that it shows too few to be laid on any other."""
    dots = detector.detect(pixels)
    return (
        dots
        if len(dots) >= _LEAST_DOTS
        else f'{name}: shows {len(dots)} dots, at least {_LEAST_DOTS} are needed'
    )


def _put_together(
    images: Sequence[SurveyImage],
    view_width: float,
    position: NDArray[np.float64],
    settings: SurveySettings,
    checkpoint: Checkpoint,
) -> list[Piece]:
    """Put the images of each span together to pieces: one, or several where the chain is torn."""
    pieces: list[Piece] = []
    spans = cut_pieces([image.T_odom_base for image in images], view_width, settings)
    for number, (first, last) in enumerate(tqdm(spans, desc='pieces', unit='piece', disable=None)):
        part = checkpoint.load_pieces(number)
        if part is None:
            part = _pieces_of_span(images, first, last, position, settings, is_linked=bool(pieces))
            checkpoint.save_pieces(number, part)
        pieces += part
    return pieces


def _pieces_of_span(
    images: Sequence[SurveyImage], first: int, last: int, position: NDArray[np.float64], settings: SurveySettings,
    *, is_linked: bool,
) -> list[Piece]:  # fmt: skip
    pieces = []
    while True:
        piece = build_piece(images, first, last, position, settings, is_linked=is_linked)
        pieces.append(piece)
        if piece.images[-1] >= last:
            return pieces
        first, is_linked = int(piece.images[-1]) + 1, False
