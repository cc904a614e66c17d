"""Tasks run in other processes and in any order give the same bytes as in this process."""

import numpy as np
import pytest
from floor_views import random_floor
from simulated_survey import OUTLINE, POSITION, SETTINGS, build_submaps_of, drive_over, lane_poses
from task_runners import Elsewhere

from floor_localizer.core.dots import DotMap
from floor_localizer.core.independent_tasks import InProcessRunner, run_indexed
from floor_localizer.core.survey.adjustment import block_partition
from floor_localizer.core.survey.array_store import MemoryArrayStore, NoCheckpoint
from floor_localizer.core.survey.floor_survey import adjust_survey
from floor_localizer.core.survey.submap_graph.connected_images import connect_images
from floor_localizer.files.array_file import DiskArrayStore


def test_a_survey_is_the_same_from_other_processes_in_any_order(tmp_path, monkeypatch):
    # Many tiles of few images.
    monkeypatch.setattr(block_partition.BlockPartitioner.__init__, '__defaults__', (1,))
    drive = drive_over(random_floor(1, (0.35, 0.2)), lane_poses((0.35, 0.2)), sway=0.1)
    left = drive.floor.points[:, 0] < 0.15
    existing = DotMap(drive.floor.points[left], drive.floor.diameters[left])
    submaps, checkpoint = build_submaps_of(drive.images), NoCheckpoint()
    connected = connect_images(drive.images, submaps, SETTINGS, MemoryArrayStore(), existing, checkpoint)
    survey = drive.images, connected, OUTLINE, POSITION, SETTINGS
    here = adjust_survey(*survey, MemoryArrayStore(), existing, InProcessRunner(), checkpoint)
    there = adjust_survey(*survey, DiskArrayStore(tmp_path / 'shelf'), existing, Elsewhere(3000), checkpoint)
    assert len(here.blocks) >= 9
    np.testing.assert_array_equal(here.dot_map.points, there.dot_map.points)
    np.testing.assert_array_equal(here.dot_map.diameters, there.dot_map.diameters)
    for name in ('counts', 'states', 'spurious_count', 'existing_count'):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    for (_, first), (_, second) in zip(here.residuals, there.residuals, strict=True):
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(('count', 'batch'), [(0, 3), (1, 3), (7, 3), (9, 3), (4, 1)])
def test_each_number_is_given_once(count, batch):
    seen: list[int] = []
    run_indexed(InProcessRunner(), seen.append, count, batch)
    assert seen == list(range(count))
