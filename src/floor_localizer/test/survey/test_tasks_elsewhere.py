"""Tasks run in other processes and in any order give the same bytes as in this process."""

import pickle
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from simulated_survey import (
    OUTLINE,
    POSITION,
    SETTINGS,
    Drive,
    build_submaps_of,
    drive_over,
    lane_poses,
    small_floor,
)

from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.independent_tasks import InProcessRunner, Task, TaskRunner, run_indexed
from floor_localizer.core.survey.adjustment import block_partition
from floor_localizer.core.survey.array_store import ArrayStore, MemoryArrayStore, NoCheckpoint
from floor_localizer.core.survey.floor_survey import SurveyResult, adjust_survey
from floor_localizer.core.survey.submap_graph.connected_images import ConnectedImages, connect_images
from floor_localizer.files.array_file import DiskArrayStore

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
    drive: Drive, connected: ConnectedImages, existing: DotMap | None, store: ArrayStore, runner: TaskRunner
) -> SurveyResult:
    return adjust_survey(
        drive.images, connected, OUTLINE, POSITION, SETTINGS, store, existing, runner, NoCheckpoint()
    )


def test_a_survey_is_the_same_from_other_processes_in_any_order(drive, tmp_path, monkeypatch):
    monkeypatch.setattr(
        block_partition.BlockPartitioner.__init__, '__defaults__', (1,)
    )  # many tiles of few images
    left = drive.floor.points[:, 0] < 0.15
    existing = DotMap(drive.floor.points[left], drive.floor.diameters[left])
    connected = connect_images(
        drive.images, build_submaps_of(drive.images), SETTINGS, MemoryArrayStore(), existing, NoCheckpoint()
    )
    here = adjusted(drive, connected, existing, MemoryArrayStore(), InProcessRunner())
    there = adjusted(drive, connected, existing, DiskArrayStore(tmp_path / 'shelf'), Elsewhere())
    assert len(here.blocks) >= 9
    for first, second in (
        (here.dot_map.points, there.dot_map.points),
        (here.dot_map.diameters, there.dot_map.diameters),
        (here.counts, there.counts),
        (here.states, there.states),
        *((a, b) for (_, a), (_, b) in zip(here.residuals, there.residuals, strict=True)),
    ):
        np.testing.assert_array_equal(first, second)
    assert (here.spurious_count, here.existing_count) == (there.spurious_count, there.existing_count)


@pytest.mark.parametrize(('count', 'batch'), [(0, 3), (1, 3), (7, 3), (9, 3), (4, 1)])
def test_each_number_is_given_once(count, batch):
    seen: list[int] = []
    run_indexed(InProcessRunner(), seen.append, count, batch)
    assert seen == list(range(count))


def test_a_missing_array_of_another_process_is_an_error(tmp_path):
    for read in (lambda store: store.get('block', 3), lambda store: store.memory_map('states')):
        with pytest.raises(FloorLocalizerError, match='use workers that see the same files'):
            read(DiskArrayStore(tmp_path))
