"""The tables of `pose_accuracy`: errors, errors over the stated covariance and over the bound, and their causes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from _centroid_noise import DotNoise, information, shared_error, true_sigmas, weights
from _floor_photographs import CAMERA
from _pose_scores import PoseScore, normalised_squares, spread, verdicts, whitened_rms
from numpy.typing import NDArray


@dataclass
class Outcome:
    """What came of one condition on one map.

    Attributes:
        name: name of the condition.
        scores: scores without a prior.
        tracked: scores with a prior.
        noise: dot noise of the views with a right pose without a prior, in the order of the scores.
    """

    name: str
    scores: list[PoseScore] = field(default_factory=list)
    tracked: list[PoseScore] = field(default_factory=list)
    noise: list[DotNoise] = field(default_factory=list)

    @property
    def right(self) -> list[PoseScore]:
        """The right poses without a prior."""
        return [score for score in self.scores if score.verdict == 'right']


def accuracy_table(outcomes: Sequence[Outcome]) -> str:
    """Return the table of errors."""
    head = (
        '| condition | right / none / wrong % | tracked | position µm: median / rms / 95 % / max '
        '| heading °: the same | error / stated: x, y, yaw | all | all, tracked | all, error / bound |'
    )
    return '\n'.join([head, '|---' * 9 + '|', *map(_accuracy_row, outcomes)])


def _accuracy_row(outcome: Outcome) -> str:
    right = outcome.right
    stated, tracked = whitened_rms(right), whitened_rms(outcome.tracked)
    components = ', '.join(f'{ratio:.2f}' for ratio in stated[:3])
    bounds = [
        planar_bound(view, sigmas)
        for view, sigmas in zip(outcome.noise, true_sigmas(outcome.noise), strict=True)
    ]
    squares = normalised_squares(np.array([score.error for score in right]), np.array(bounds))
    return (
        f'| {outcome.name} | {verdicts(outcome.scores)} | {verdicts(outcome.tracked)} '
        f'| {spread([1e6 * score.distance for score in right], ".1f")} '
        f'| {spread([math.degrees(score.turn) for score in right], ".4f")} '
        f'| {components} | {stated[3]:.2f} | {tracked[3]:.2f} | {math.sqrt(np.mean(squares) / 3.0):.2f} |'
    )


def cause_table(outcomes: Sequence[Outcome]) -> str:
    """Return the table of what the ratios come from."""
    head = (
        '| condition | matched dots a view: alone + touching | rms centroid error px | error / sigma | shared px '
        '| stated / bound for the stated sigmas | error / stated expected |'
    )
    return '\n'.join([head, '|---' * 7 + '|', *map(_cause_row, outcomes)])


def _cause_row(outcome: Outcome) -> str:
    views, stated = outcome.noise, np.array([score.covariance for score in outcome.right])
    alone = np.concatenate([view.alone for view in views])
    errors = np.concatenate([view.errors for view in views])
    ratios = errors / np.concatenate([view.sigmas for view in views])[:, None]
    own = [planar_bound(view, view.sigmas) for view in views]
    agreement = np.diagonal(stated, axis1=1, axis2=2) / np.diagonal(own, axis1=1, axis2=2)
    expected = [
        np.trace(np.linalg.inv(covariance) @ _scatter(view, sigmas)) / 3.0
        for view, sigmas, covariance in zip(views, true_sigmas(views), stated, strict=True)
    ]
    shared = shared_error(views, (CAMERA.width, CAMERA.height))
    return (
        f'| {outcome.name} | {alone.sum() / len(views):.1f} + {(~alone).sum() / len(views):.1f} '
        f'| {_rms(errors[alone]):.3f} / {_rms(errors[~alone]):.3f} '
        f'| {_rms(ratios[alone]):.2f} / {_rms(ratios[~alone]):.2f} | {shared:.4f} '
        f'| {math.sqrt(np.mean(agreement)):.3f} | {math.sqrt(np.mean(expected)):.2f} |'
    )


def planar_bound(view: DotNoise, sigmas: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Cramér-Rao bound of x, y and yaw, shape (3, 3), for the centroids' deviations [px]."""
    return np.asarray(np.linalg.inv(information(view, weights(view, sigmas)))[:3, :3])


def _scatter(view: DotNoise, sigmas: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the covariance of a fit that weighs by the stated deviations what scatters by the true ones, (3, 3)."""
    stated, true = weights(view, view.sigmas), np.linalg.inv(weights(view, sigmas))
    inverse = np.linalg.inv(information(view, stated))
    return np.asarray((inverse @ information(view, stated @ true @ stated) @ inverse)[:3, :3])


def _rms(values: NDArray[np.float64]) -> float:
    return math.sqrt(np.mean(values**2)) if values.size else math.nan
