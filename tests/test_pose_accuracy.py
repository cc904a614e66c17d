"""Errors of poses from rendered images are as large as their covariance says: chi-square, within its own chance."""

from dataclasses import replace
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from scene_simulator.floor.dot_floor import DARK_ON_LIGHT, SURVEY_ERROR
from shirube_core.geometry import SE2

pytestmark = pytest.mark.newest_set_only

BENCHMARK = 'pose_accuracy'
VIEWS = 60
# Chance leaves these limits once in a thousand runs.
LOW, HIGH = 0.0005, 0.9995


@pytest.fixture(scope='module')
def outcomes(bench: ModuleType) -> Any:
    """What comes of a condition on a small floor."""
    size = (1.8, 1.8)
    design = replace(DARK_ON_LIGHT, size=size, count=round(5384 * size[0] * size[1]))
    floors = {error: bench.SurveyedFloor(design, error) for error in (0.0, SURVEY_ERROR)}

    @cache
    def outcome(number: int, survey_error: float) -> Any:
        return bench.outcome(floors[survey_error], bench.CONDITIONS[number], VIEWS, 1)

    return outcome


def normalised(scores: list[Any]) -> np.ndarray:
    return np.array([score.error @ np.linalg.solve(score.covariance, score.error) for score in scores])


@pytest.mark.parametrize('number', range(6))
def test_errors_are_those_that_the_covariance_states(outcomes: Any, number: int) -> None:
    outcome = outcomes(number, SURVEY_ERROR)
    for scores in (outcome.scores, outcome.tracked):
        assert [score.verdict for score in scores] == ['right'] * VIEWS
        assert chi2.ppf(LOW, 3 * VIEWS) < np.sum(normalised(scores)) < chi2.ppf(HIGH, 3 * VIEWS)


@pytest.mark.parametrize('number', [0, 4])
def test_with_an_exact_map_a_pose_is_exact_to_a_hundredth_of_a_millimetre(outcomes: Any, number: int) -> None:
    outcome = outcomes(number, 0.0)
    assert max(score.distance for score in (*outcome.scores, *outcome.tracked)) < 1e-5
    assert max(score.turn for score in (*outcome.scores, *outcome.tracked)) < 2e-4


def test_deviations_from_an_ideal_line_are_none(bench: ModuleType) -> None:
    poses = [SE2(0.3 + 0.012 * k * 0.6, 0.2 + 0.012 * k * 0.8, 0.9) for k in range(51)]
    away, turned = bench.deviations(poses)
    np.testing.assert_allclose(away, 0.0, atol=1e-12)
    np.testing.assert_allclose(turned, 0.0, atol=1e-12)
