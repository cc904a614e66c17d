"""Difficult images give the right pose or none, never a wrong one; the benchmark of that name runs more."""

from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from floor_localizer.core.fix import NoFix
from scene_simulator.floor.dot_floor import DARK_ON_LIGHT

pytestmark = pytest.mark.newest_set_only

BENCHMARK = 'hard_pictures'
SIZE = (1.2, 1.2)
SHARE = SIZE[0] * SIZE[1] / (DARK_ON_LIGHT.size[0] * DARK_ON_LIGHT.size[1])
VIEWS = 6
CONDITIONS = (
    *('clean', 'shadow edge', 'reflections', 'motion blur 3 px', 'motion blur 6 px', 'motion blur 10 px'),
    *('half covered', 'wet spots', '4x fewer dots', 'dots 3x larger', 'low contrast', 'JPEG at quality 30'),
)


@pytest.fixture(scope='module')
def floor_of(bench: ModuleType) -> Any:
    """A small floor of a design; the same one each time."""
    floors: dict[Any, Any] = {}

    def floor(design: Any) -> Any:
        if design not in floors:
            small = replace(design, size=SIZE, count=round(SHARE * design.count))
            floors[design] = bench.SurveyedFloor(small)
        return floors[design]

    return floor


def test_every_condition_is_tested(bench: ModuleType) -> None:
    assert tuple(condition.name for condition in bench.CONDITIONS) == CONDITIONS


@pytest.mark.parametrize('number', range(len(CONDITIONS)), ids=CONDITIONS)
def test_a_pose_is_right_or_there_is_none(bench: ModuleType, floor_of: Any, number: int) -> None:
    condition = bench.CONDITIONS[number]
    outcome = bench.hard_outcome(floor_of(condition.design), condition, VIEWS, seed=2)
    verdicts = [score.verdict for score in (*outcome.scores, *outcome.tracked)]
    assert verdicts.count('wrong') == 0
    # Puddles and bare floor may leave too few dots, now and then.
    assert verdicts.count('right') >= VIEWS


def test_a_floor_that_is_not_the_maps_gives_no_pose(bench: ModuleType, floor_of: Any) -> None:
    other = bench.SurveyedFloor(floor_of(DARK_ON_LIGHT).design, seed=5)
    for condition in bench.CONDITIONS:
        if condition.design is DARK_ON_LIGHT:
            photograph = condition.photograph(other.floor, next(other.places(1)), np.random.default_rng(0))
            found = floor_of(DARK_ON_LIGHT).localizer.locate(photograph.image, bench.CAMERA)
            assert isinstance(found, NoFix)
