"""Tasks run in other processes and in any order give the same bytes as in this process."""

import pickle
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from simulated_survey import (
    OUTLINE,
    POSITION,
    SETTINGS,
    Drive,
    drive_over,
    lane_poses,
    pieces_of,
    small_floor,
)

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.independent_tasks import OwnProcess, Task, TaskRunner, run_numbered
from floor_localizer.core.survey import block_cutting
from floor_localizer.core.survey.floor_survey import SurveyResult, adjust_survey
from floor_localizer.core.survey.linked_images import LinkedImages, link_images
from floor_localizer.core.survey.shelf import MemoryShelf, Shelf
from floor_localizer.core.survey.survey_record import NoRecord
from floor_localizer.survey_files.shelf_folder import ShelfFolder

MOST_PICKLED = 3000
"""Largest size of a pickled task, whose data are in the array store [B]."""


class Elsewhere:
    """Runs pickled copies of the tasks in reverse order, as other processes may do."""

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        for given in reversed(arguments):
            text = pickle.dumps((function, given))
            assert len(text) < MOST_PICKLED
            copy, copied = pickle.loads(text)
            copy(*copied)
            yield


@pytest.fixture(scope='module')
def drive() -> Drive:
    return drive_over(small_floor(1, (0.35, 0.2)), lane_poses((0.35, 0.2)), sway=0.1)


def adjusted(
    drive: Drive, linked: LinkedImages, existing: DotMap | None, shelf: Shelf, runner: TaskRunner
) -> SurveyResult:
    return adjust_survey(
        drive.images, linked, OUTLINE, POSITION, SETTINGS, shelf, existing, runner, NoRecord()
    )


def test_a_survey_is_the_same_from_other_processes_in_any_order(
    drive: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(block_cutting.BlockCutter.__init__, '__defaults__', (1,))  # many tiles of few images
    left = drive.floor.points[:, 0] < 0.15
    existing = DotMap(drive.floor.points[left], drive.floor.diameters[left])
    linked = link_images(drive.images, pieces_of(drive.images), SETTINGS, MemoryShelf(), existing, NoRecord())
    here = adjusted(drive, linked, existing, MemoryShelf(), OwnProcess())
    there = adjusted(drive, linked, existing, ShelfFolder(tmp_path / 'shelf'), Elsewhere())
    assert len(here.blocks) >= 9
    for first, second in (
        (here.dot_map.points, there.dot_map.points),
        (here.dot_map.diameters, there.dot_map.diameters),
        (here.counts, there.counts),
        (here.states, there.states),
        *((a, b) for (_, a), (_, b) in zip(here.residuals, there.residuals, strict=True)),
    ):
        np.testing.assert_array_equal(first, second)
    assert (here.dirt, here.existing_count) == (there.dirt, there.existing_count)


@pytest.mark.parametrize(('count', 'batch'), [(0, 3), (1, 3), (7, 3), (9, 3), (4, 1)])
def test_each_number_is_given_once(count: int, batch: int) -> None:
    seen: list[int] = []
    run_numbered(OwnProcess(), seen.append, count, batch)
    assert seen == list(range(count))


def test_what_another_process_wrote_elsewhere_is_told(tmp_path: Path) -> None:
    for read in (lambda shelf: shelf.get('block', 3), lambda shelf: shelf.look_up('states')):
        with pytest.raises(FloorLocalizerError, match='use workers that see the same files'):
            read(ShelfFolder(tmp_path))
