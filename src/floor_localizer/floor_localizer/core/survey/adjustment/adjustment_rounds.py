"""Repeated bundle adjustment: each round merges observations into dots more strictly and re-estimates the priors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from floor_localizer.core.arrays import Floats
from floor_localizer.core.independent_tasks import TaskRunner
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.adjustment.block_partition import BlockPartitioner
from floor_localizer.core.survey.adjustment.bundle_adjustment import SuspensionPriors, bundle_adjust_blocks
from floor_localizer.core.survey.adjustment.dot_estimation import drop_outliers
from floor_localizer.core.survey.adjustment.existing_dots import ExistingDots, fix_dots
from floor_localizer.core.survey.adjustment.observations import ObservationBlocks
from floor_localizer.core.survey.array_store import StepCheckpoint

# Merge distance of each round, in units of the setting; submaps are less accurate than adjusted images.
_MERGE_FACTORS = (1.6, 1.0, 0.8)
ADJUSTMENTS = 2 * len(_MERGE_FACTORS)
"""Two for each merge distance: with outliers, then without."""
# Lower bound of the prior standard deviations: relative height, and tilt [rad].
_MIN_SIGMA = 3e-5


@dataclass(frozen=True)
class AdjustmentRounds:
    """Adjusts all images; adjustments found in the checkpoint are not repeated.

    Attributes:
        partitioner: partitions the observations into blocks.
        existing_dots: dots of the map to extend.
        position: optical centre in the base frame, shape (3,) [m].
        settings: survey settings.
        runner: runs the tasks; they must see the cutter's array store.
        checkpoint: checkpoint of the adjustments.
        progress: callback with the number of finished `ADJUSTMENTS`.
    """

    partitioner: BlockPartitioner
    existing_dots: ExistingDots
    position: Floats
    settings: SurveySettings
    runner: TaskRunner
    checkpoint: StepCheckpoint
    progress: Callable[[int], None]

    def run(self, states: Floats) -> tuple[ObservationBlocks, Floats]:
        """Return the observations of each dot, without outliers, and the adjusted states, from initial states."""
        priors = SuspensionPriors(self.position, self.settings.scale_sigma, self.settings.tilt_sigma)
        for number, merge_distance in enumerate(_MERGE_FACTORS):
            adjusted = self._load_step(2 * number + 1)
            if adjusted is None or number == len(_MERGE_FACTORS) - 1:
                blocks = self._partition(states, merge_distance * self.settings.merge_distance)
                with_outliers = self._adjust(2 * number, blocks, states, priors)
                drop_outliers(blocks, with_outliers, self.position, self.runner)
                adjusted = self._adjust(2 * number + 1, blocks, with_outliers, priors)
            states = adjusted
            priors = estimate_priors(states, self.position, self.settings)
        return blocks, states

    def _partition(self, states: Floats, merge_distance: float) -> ObservationBlocks:
        blocks = self.partitioner.partition(states, merge_distance)
        if self.existing_dots.count:
            fix_dots(blocks, states, self.position, self.existing_dots, merge_distance, self.runner)
        return blocks

    def _adjust(
        self, step: int, blocks: ObservationBlocks, states: Floats, priors: SuspensionPriors
    ) -> Floats:
        adjusted = self._load_step(step)
        if adjusted is None:
            adjusted = bundle_adjust_blocks(blocks, states, priors, self.runner)
            self.checkpoint.save_step(f'adjusted_{step}', states=adjusted)
        self.progress(step + 1)
        return adjusted

    def _load_step(self, step: int) -> Floats | None:
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
