"""The tasks of a survey. Each writes its result to the checkpoint, so it can run in any process and be repeated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction import DotDetector
from floor_localizer.core.survey.submap import Submap, build_submap
from floor_localizer.core.survey.survey_settings import SurveySettings
from floor_localizer.survey_files.checkpoint import Checkpoint, Detection
from floor_localizer.survey_files.image_batches import ImageBatch
from floor_localizer.survey_files.packed_images import PackedImages

_MIN_DOTS = 8


def detect_dots(checkpoint: Checkpoint, chunk: int, batch: ImageBatch, names: Sequence[str]) -> None:
    """Detect the dots of a chunk of images.

    Args:
        checkpoint: checkpoint of the survey.
        chunk: number of the chunk.
        batch: images of the chunk.
        names: names of the images, for messages.
    """
    detector = DotDetector()
    found: dict[int, Detection] = {}
    for (index, pixels), name in zip(batch, names, strict=True):
        found[index] = pixels if isinstance(pixels, str) else _detect_image(detector, pixels, name)
    checkpoint.save_dots(chunk, found)


def _detect_image(detector: DotDetector, pixels: NDArray[np.uint8], name: str) -> Detection:
    """Return the dots of an image, or a message that they are too few to match another image."""
    dots = detector.detect(pixels)
    if len(dots) < _MIN_DOTS:
        return f'{name}: shows {len(dots)} dots, at least {_MIN_DOTS} are needed'
    return dots


def build_span_submaps(
    checkpoint: Checkpoint,
    span: int,
    packed: PackedImages,
    first: int,
    position: NDArray[np.float64],
    settings: SurveySettings,
) -> None:
    """Build the submaps of a span of images: one, or several where consecutive images do not match.

    Args:
        checkpoint: checkpoint of the survey.
        span: number of the span; consecutive spans share an image.
        packed: images of the span.
        first: index in the survey of the first image.
        position: optical centre in the base frame, shape (3,) [m].
        settings: survey settings.
    """
    images, submaps = list(packed), list[Submap]()
    begin, last, is_continuation = 0, len(images) - 1, span > 0
    while begin <= last:
        submap = build_submap(images, begin, last, position, settings, is_continuation=is_continuation)
        begin, is_continuation = int(submap.images[-1]) + 1, False
        submaps.append(replace(submap, images=submap.images + first))
    checkpoint.save_submaps(span, submaps)
