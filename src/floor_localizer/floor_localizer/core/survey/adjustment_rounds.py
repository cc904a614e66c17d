"""Repeated bundle adjustment: each round merges observations into dots more strictly and re-estimates the priors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.independent_tasks import TaskRunner
from floor_localizer.core.survey.adjustment import BodyPriors, adjust_blocks
from floor_localizer.core.survey.block_cutting import BlockCutter
from floor_localizer.core.survey.fixed_dots import fix_dots
from floor_localizer.core.survey.old_dots import OldDots
from floor_localizer.core.survey.outliers import drop_outliers
from floor_localizer.core.survey.sighting_blocks import SightingBlocks
from floor_localizer.core.survey.survey_record import SurveyRecord
from floor_localizer.core.survey.survey_settings import SurveySettings

# Merge distance of each round, in units of the setting; submaps are less accurate than adjusted images.
_REACHES = (1.6, 1.0, 0.8)
ADJUSTMENTS = 2 * len(_REACHES)
"""Two for each merge distance: with outliers, then without."""
# Lower bound of the prior standard deviations: relative height, and tilt [rad].
_STIFFEST = 3e-5


@dataclass(frozen=True)
class AdjustmentRounds:
    """Adjusts all images; adjustments found in the checkpoint are not repeated.

    Attributes:
        cutter: partitions the observations into blocks.
        old_dots: dots of the map to extend.
        position: optical centre in the base frame, shape (3,) [m].
        settings: survey settings.
        runner: runs the tasks; they must see the cutter's array store.
        record: checkpoint of the adjustments.
        progress: callback with the number of finished `ADJUSTMENTS`.
    """

    cutter: BlockCutter
    old_dots: OldDots
    position: NDArray[np.float64]
    settings: SurveySettings
    runner: TaskRunner
    record: SurveyRecord
    progress: Callable[[int], None]

    def run(self, states: NDArray[np.float64]) -> tuple[SightingBlocks, NDArray[np.float64]]:
        """Return the observations of each dot, without outliers, and the adjusted states.

        Args:
            states: initial states, shape (k, 6).
        """
        priors = BodyPriors(self.position, self.settings.scale_sigma, self.settings.tilt_sigma)
        for number, reach in enumerate(_REACHES):
            adjusted = self._recorded(2 * number + 1)
            if adjusted is None or number == len(_REACHES) - 1:
                blocks = self._cut(states, reach * self.settings.same_dot)
                with_outliers = self._adjusted(2 * number, blocks, states, priors)
                drop_outliers(blocks, with_outliers, self.position, self.runner)
                adjusted = self._adjusted(2 * number + 1, blocks, with_outliers, priors)
            states = adjusted
            priors = learned_priors(states, self.position, self.settings)
        return blocks, states

    def _cut(self, states: NDArray[np.float64], reach: float) -> SightingBlocks:
        blocks = self.cutter.cut(states, reach)
        if self.old_dots.count:
            fix_dots(blocks, states, self.position, self.old_dots, reach, self.runner)
        return blocks

    def _adjusted(
        self, step: int, blocks: SightingBlocks, states: NDArray[np.float64], priors: BodyPriors
    ) -> NDArray[np.float64]:
        adjusted = self._recorded(step)
        if adjusted is None:
            adjusted = adjust_blocks(blocks, states, priors, self.runner)
            self.record.keep(f'adjusted_{step}', states=adjusted)
        self.progress(step + 1)
        return adjusted

    def _recorded(self, step: int) -> NDArray[np.float64] | None:
        known = self.record.recall(f'adjusted_{step}')
        return None if known is None else known['states']


def learned_priors(
    states: NDArray[np.float64], position: NDArray[np.float64], settings: SurveySettings
) -> BodyPriors:
    """Return priors with the standard deviations found in the adjusted states, limited by the settings.

    Priors that are too wide for a stiff robot would let the map bend: a hundred consecutive images can share a tilt
    that is not significant in any single one of them.

    Args:
        states: states of all images, shape (k, 6).
        position: optical centre in the base frame, shape (3,) [m].
        settings: survey settings.
    """
    scale, roll, pitch = np.sqrt(np.mean(states[:, 3:] ** 2, axis=0))
    tilt = np.hypot(roll, pitch) / np.sqrt(2.0)
    return BodyPriors(
        position,
        float(np.clip(scale, _STIFFEST, settings.scale_sigma)),
        float(np.clip(tilt, _STIFFEST, settings.tilt_sigma)),
    )
