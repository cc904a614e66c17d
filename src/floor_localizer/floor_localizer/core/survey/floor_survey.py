"""From pieces to one map: place them, adjust all images and dots at once, drop dirt."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.independent_tasks import OwnProcess, TaskRunner
from floor_localizer.core.survey.adjustment_rounds import AdjustmentRounds
from floor_localizer.core.survey.block_cutting import BlockCutter
from floor_localizer.core.survey.linked_images import LinkedImages, link_images
from floor_localizer.core.survey.old_dots import shelve_dots
from floor_localizer.core.survey.piece import Piece
from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.sighting_blocks import SightingBlocks
from floor_localizer.core.survey.survey_image import ImageSelection, SurveyImage, ViewOutline
from floor_localizer.core.survey.survey_record import NoRecord, SurveyRecord
from floor_localizer.core.survey.survey_settings import SurveySettings
from floor_localizer.core.survey.surveyed_dots import Residuals, gather_dots


@dataclass(frozen=True)
class SurveyResult:
    """A surveyed floor.

    Attributes:
        dot_map: the dots; those of the map that was extended come first, as they were.
        counts: shape (n,), how many images saw each dot; 0 for dots of the old map that none saw.
        images: indices of the images that were used.
        states: shape (k, 6), of these: x, y [m], yaw [rad], scale, roll, pitch [rad].
        blocks: the sightings; their images are indices of ``images``.
        residuals: of the sightings, block by block.
        loops: number of links between pieces that do not follow each other.
        dirt: number of dots that were dropped.
        left_out: indices of images that are linked to no others.
        old_dots: number of dots of the map that was extended.
    """

    dot_map: DotMap
    counts: NDArray[np.int64]
    images: NDArray[np.int64]
    states: NDArray[np.float64]
    blocks: SightingBlocks
    residuals: Residuals
    loops: int
    dirt: int
    left_out: NDArray[np.int64]
    old_dots: int


def survey_floor(
    images: Sequence[SurveyImage],
    pieces: Iterable[Piece],
    outline: ViewOutline,
    position: NDArray[np.float64],
    settings: SurveySettings,
    shelf: Shelf,
    existing: DotMap | None = None,
) -> SurveyResult:
    """Make one map in this process; pieces in their order, other arguments as of `adjust_survey`.

    Raises:
        FloorLocalizerError: the images do not overlap.
    """
    record = NoRecord()
    linked = link_images(images, pieces, settings, shelf, existing, record)
    return adjust_survey(images, linked, outline, position, settings, shelf, existing, OwnProcess(), record)


def adjust_survey(
    images: Sequence[SurveyImage],
    linked: LinkedImages,
    outline: ViewOutline,
    position: NDArray[np.float64],
    settings: SurveySettings,
    shelf: Shelf,
    existing: DotMap | None,
    runner: TaskRunner,
    record: SurveyRecord,
    progress: Callable[[int], None] = lambda _: None,
) -> SurveyResult:
    """Make the map of images that are linked.

    Args:
        images: all images of the survey.
        linked: those of them that are on the map.
        outline: what an image shows.
        position: of the optical centre in the base frame [m].
        settings: of the survey.
        shelf: for what does not fit into memory; the result needs it further on.
        existing: a map that is extended; its dots stay where they are.
        runner: of tasks that see the shelf; the map is the same whatever it is.
        record: of the adjustments; those that are in it are not done again.
        progress: is told how many of `adjustment_rounds.ADJUSTMENTS` are done.
    """
    old = DotMap(np.empty((0, 2)), np.empty(0)) if existing is None else existing
    chosen = ImageSelection(images, linked.images)
    cutter = BlockCutter(chosen, position, settings.dot_sigma, shelf, runner)
    old_dots = shelve_dots(old.points, shelf)
    rounds = AdjustmentRounds(cutter, old_dots, position, settings, runner, record, progress)
    blocks, states = rounds.run(linked.states)
    dots = gather_dots(blocks, states, position, outline, old, old_dots, runner)
    return SurveyResult(
        dots.dot_map, dots.counts, linked.images, states, blocks, Residuals(blocks), linked.loops, dots.dirt,
        np.setdiff1d(np.arange(len(images)), linked.images), dots.old_dots,
    )  # fmt: skip
