"""From submaps to one map: optimise the pose graph, adjust all images and dots, drop spurious dots; scale it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.independent_tasks import InProcessRunner, TaskRunner
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.adjustment.block_partition import BlockPartitioner
from floor_localizer.core.survey.adjustment.bundle_adjustment import SuspensionPriors, bundle_adjust_blocks
from floor_localizer.core.survey.adjustment.observations import ObservationBlocks
from floor_localizer.core.survey.adjustment.surveyed_dots import (
    Residuals,
    collect_dots,
    drop_outliers,
    fix_dots,
    store_existing_dots,
)
from floor_localizer.core.survey.array_store import ArrayStore, NoCheckpoint, StepCheckpoint
from floor_localizer.core.survey.submap import Submap
from floor_localizer.core.survey.submap_graph.connected_images import ConnectedImages, connect_images
from floor_localizer.core.survey.survey_image import SurveyImage, ViewOutline

# Search radius around the given position of a dot [m].
_SEARCH_RADIUS = 0.01
# Largest relative difference between the tape and the camera's calibration.
_MAX_SCALE_CHANGE = 0.1
# Merge distance of each round, in units of the setting; submaps are less accurate than adjusted images.
_MERGE_FACTORS = (1.6, 1.0, 0.8)
ADJUSTMENTS = 2 * len(_MERGE_FACTORS)  # two for each merge distance: with outliers, then without
# Lower bound of the prior standard deviations: relative height, and tilt [rad].
_MIN_SIGMA = 3e-5


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
        loop_closures: number of loop closures.
        spurious_count: number of spurious dots that were dropped.
        unconnected: indices of images that are not connected to the map.
        existing_count: number of dots of the extended map.
    """

    dot_map: DotMap
    counts: Ints
    images: Ints
    states: Floats
    blocks: ObservationBlocks
    residuals: Residuals
    loop_closures: int
    spurious_count: int
    unconnected: Ints
    existing_count: int


def survey_floor(
    images: Sequence[SurveyImage],
    submaps: Iterable[Submap],
    outline: ViewOutline,
    position: Floats,
    settings: SurveySettings,
    store: ArrayStore,
    existing: DotMap | None = None,
) -> SurveyResult:
    """Make a map in this process from submaps in order; arguments and errors as for `adjust_survey`."""
    checkpoint = NoCheckpoint()
    connected = connect_images(images, submaps, settings, store, existing, checkpoint)
    return adjust_survey(images, connected, outline, position, settings, store, existing, InProcessRunner(), checkpoint)


def adjust_survey(
    images: Sequence[SurveyImage],
    connected: ConnectedImages,
    outline: ViewOutline,
    position: Floats,
    settings: SurveySettings,
    store: ArrayStore,
    existing: DotMap | None,
    runner: TaskRunner,
    checkpoint: StepCheckpoint,
    progress: Callable[[int], None] = lambda _: None,
) -> SurveyResult:
    """Make the map of connected images; adjustments found in the checkpoint are not repeated.

    The store is for what does not fit into memory; the result still reads from it. The dots of an existing map keep
    their position. The runner does not change the map. ``progress`` gets the number of finished `ADJUSTMENTS`,
    ``position`` is the optical centre in the base frame, shape (3,) [m].
    """
    # 1. Store the observations of the connected images, and the dots of the map to extend.
    old = DotMap(np.empty((0, 2)), np.empty(0)) if existing is None else existing
    partitioner = BlockPartitioner(images, connected.images, position, settings.dot_sigma, store, runner)
    existing_dots = store_existing_dots(old.points, store)
    states, priors = connected.states, SuspensionPriors(position, settings.scale_sigma, settings.tilt_sigma)
    adjust = _CheckpointedAdjustment(runner, checkpoint, progress)
    for number, merge_factor in enumerate(_MERGE_FACTORS):
        adjusted = adjust.saved_states(2 * number + 1)
        if adjusted is None or number == len(_MERGE_FACTORS) - 1:
            # 2. Merge the observations into dots, more strictly in each round; known dots are fixed.
            merge_distance = merge_factor * settings.merge_distance
            blocks = partitioner.partition(states, merge_distance)
            if existing_dots.count:
                fix_dots(blocks, states, position, existing_dots, merge_distance, runner)
            # 3. Adjust all images and dots, with outliers and without.
            with_outliers = adjust(2 * number, blocks, states, priors)
            drop_outliers(blocks, with_outliers, position, runner)
            adjusted = adjust(2 * number + 1, blocks, with_outliers, priors)
        # 4. Estimate the motion of the suspension for the next round.
        states, priors = adjusted, estimate_priors(adjusted, position, settings)
    # 5. Collect the dots, without spurious ones.
    dot_map, counts, spurious = collect_dots(blocks, states, position, outline, old, existing_dots, runner)
    unconnected = np.setdiff1d(np.arange(len(images)), connected.images)
    return SurveyResult(
        dot_map, counts, connected.images, states, blocks, Residuals(blocks), connected.loop_closures, spurious,
        unconnected, len(old),
    )  # fmt: skip


@dataclass(frozen=True)
class _CheckpointedAdjustment:
    """Adjusts the blocks of a step, unless the checkpoint has its states."""

    runner: TaskRunner
    checkpoint: StepCheckpoint
    progress: Callable[[int], None]

    def __call__(self, step: int, blocks: ObservationBlocks, states: Floats, priors: SuspensionPriors) -> Floats:
        adjusted = self.saved_states(step)
        if adjusted is None:
            adjusted = bundle_adjust_blocks(blocks, states, priors, self.runner)
            self.checkpoint.save_step(f'adjusted_{step}', states=adjusted)
        self.progress(step + 1)
        return adjusted

    def saved_states(self, step: int) -> Floats | None:
        saved = self.checkpoint.load_step(f'adjusted_{step}')
        return None if saved is None else saved['states']


def estimate_priors(states: Floats, position: Floats, settings: SurveySettings) -> SuspensionPriors:
    """Return priors with the standard deviations found in the adjusted states, limited by the settings.

    Priors that are too wide for a stiff robot would let the map bend: a hundred consecutive images can share a tilt
    that is not significant in any single one of them.
    """
    scale, roll, pitch = np.sqrt(np.mean(states[:, 3:] ** 2, axis=0))
    tilt = np.hypot(roll, pitch) / np.sqrt(2.0)
    return SuspensionPriors(
        position,
        float(np.clip(scale, _MIN_SIGMA, settings.scale_sigma)),
        float(np.clip(tilt, _MIN_SIGMA, settings.tilt_sigma)),
    )


@dataclass(frozen=True)
class KnownLength:
    """A measured distance [m], and the positions of both dots on the map before scaling, (2,) [m]."""

    first: Floats
    second: Floats
    length: float


def scale_survey(result: SurveyResult, known: KnownLength) -> tuple[SurveyResult, float]:
    """Return the scaled survey and the factor; raise a FloorLocalizerError for no dot there or a wrong length."""
    ends = np.array([_dot_at(result.dot_map, position) for position in (known.first, known.second)])
    mapped = float(np.hypot(*(ends[1] - ends[0])))
    if mapped < 2.0 * _SEARCH_RADIUS or not abs(known.length / mapped - 1.0) < _MAX_SCALE_CHANGE:
        raise FloorLocalizerError(
            f'--known-length: is {known.length:g} m, but the dots are {mapped:.4f} m apart on the map; '
            'check which dots were measured, and camera_xyz'
        )
    scale = known.length / mapped
    states = result.states.copy()
    states[:, :2] *= scale
    states[:, 3] = scale * (1.0 + states[:, 3]) - 1.0
    dot_map = DotMap(scale * result.dot_map.points, scale * result.dot_map.diameters)
    residuals = replace(result.residuals, scale=scale * result.residuals.scale)
    return replace(result, dot_map=dot_map, states=states, residuals=residuals), scale


def _dot_at(dot_map: DotMap, position: Floats) -> Floats:
    distances = np.hypot(*(dot_map.points - position).T)
    nearest = int(np.argmin(distances))
    if distances[nearest] > _SEARCH_RADIUS:
        raise FloorLocalizerError(
            f'--known-length: ({position[0]:g}, {position[1]:g}) m has no dot within {1e3 * _SEARCH_RADIUS:.0f} mm; '
            'give the positions of two dots as they are in the map without --known-length'
        )
    return dot_map.points[nearest]
