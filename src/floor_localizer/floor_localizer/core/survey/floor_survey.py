"""From submaps to one map: optimise the pose graph, adjust all images and dots, drop spurious dots."""

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
        dot_map: the dots; those of the extended map come first, unchanged.
        counts: number of images that observed each dot, shape (n,); 0 for dots of the existing map that none observed.
        images: indices of the images on the map, shape (k,).
        states: x, y [m], yaw [rad], scale, roll, pitch [rad] of these images, shape (k, 6).
        blocks: the observations; their image numbers are indices into ``images``.
        residuals: residuals of the observations, block by block.
        loops: number of loop closures.
        dirt: number of spurious dots that were dropped.
        left_out: indices of images that are not connected to the map.
        existing_count: number of dots of the extended map.
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
    existing_count: int


def survey_floor(
    images: Sequence[SurveyImage],
    pieces: Iterable[Piece],
    outline: ViewOutline,
    position: NDArray[np.float64],
    settings: SurveySettings,
    shelf: Shelf,
    existing: DotMap | None = None,
) -> SurveyResult:
    """Make a map in this process from submaps in order; other arguments as for `adjust_survey`.

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
    """Make the map of connected images.

    Args:
        images: all images of the survey.
        linked: the connected images and their initial states.
        outline: outline of a view.
        position: optical centre in the base frame, shape (3,) [m].
        settings: survey settings.
        shelf: array store for what does not fit into memory; the result still reads from it.
        existing: map to extend, None for a new one; its dots keep their position.
        runner: runs the tasks; they must see the array store. It does not change the map.
        record: checkpoint of the adjustments; those found in it are not repeated.
        progress: callback with the number of finished `adjustment_rounds.ADJUSTMENTS`.
    """
    old = DotMap(np.empty((0, 2)), np.empty(0)) if existing is None else existing
    chosen = ImageSelection(images, linked.images)
    cutter = BlockCutter(chosen, position, settings.dot_sigma, shelf, runner)
    old_dots = shelve_dots(old.points, shelf)
    rounds = AdjustmentRounds(cutter, old_dots, position, settings, runner, record, progress)
    blocks, states = rounds.run(linked.states)
    dots = gather_dots(blocks, states, position, outline, old, old_dots, runner)
    return SurveyResult(
        dots.dot_map, dots.counts, linked.images, states, blocks, Residuals(blocks), linked.loops,
        dots.dirt, np.setdiff1d(np.arange(len(images)), linked.images), dots.existing_count,
    )  # fmt: skip
