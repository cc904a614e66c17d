"""The tasks of a survey. Each writes its result to the checkpoint, so it can run in any process and be repeated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction import DotDetector
from floor_localizer.core.survey.piece import Piece, build_piece
from floor_localizer.core.survey.survey_settings import SurveySettings
from floor_localizer.survey_files.checkpoint import Checkpoint, Found
from floor_localizer.survey_files.image_parts import ImagePart
from floor_localizer.survey_files.packed_images import PackedImages

_LEAST_DOTS = 8


def find_dots(checkpoint: Checkpoint, chunk: int, part: ImagePart, names: Sequence[str]) -> None:
    """Detect the dots of a chunk of images.

    Args:
        checkpoint: checkpoint of the survey.
        chunk: number of the chunk.
        part: images of the chunk.
        names: names of the images, for messages.
    """
    detector = DotDetector()
    found: dict[int, Found] = {}
    for (index, pixels), name in zip(part, names, strict=True):
        found[index] = pixels if isinstance(pixels, str) else _dots_of(detector, pixels, name)
    checkpoint.save_dots(chunk, found)


def _dots_of(detector: DotDetector, pixels: NDArray[np.uint8], name: str) -> Found:
    """Return the dots of an image, or a message that they are too few to match another image."""
    dots = detector.detect(pixels)
    if len(dots) < _LEAST_DOTS:
        return f'{name}: shows {len(dots)} dots, at least {_LEAST_DOTS} are needed'
    return dots


def put_together(
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
    images, pieces = list(packed), list[Piece]()
    begin, last, is_linked = 0, len(images) - 1, span > 0
    while begin <= last:
        piece = build_piece(images, begin, last, position, settings, is_linked=is_linked)
        begin, is_linked = int(piece.images[-1]) + 1, False
        pieces.append(replace(piece, images=piece.images + first))
    checkpoint.save_pieces(span, pieces)
