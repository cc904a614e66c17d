"""The recorded drive through a room matches the simulator, and its map matches the room."""

from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import cv2
import numpy as np
import pytest
from node_testing import isolated_graph

from reward_planner.core.depth.stereo_pair import pair_from_projections
from reward_planner.core.depth.trinocular_depth import TrinocularDepth
from reward_planner.core.settings import DepthSettings
from reward_planner.node import RewardPlannerNode
from scene_simulator.commands.room import RESOLUTION, true_map
from scene_simulator.room.room_drive import RoomDrive
from shirube_bags.bag_reader import BagReader
from shirube_bags.bag_writer import BagWriter
from shirube_bags.lockstep import replay_in_lockstep

pytestmark = pytest.mark.newest_set_only

BENCHMARK = '_room_drive'
SCENE = RoomDrive()
CAMERA_TOPICS = ('image_rect/compressed', 'camera_info')
TOPICS = ['/pose', *(f'/{name}/{topic}' for name in ('left', 'right', 'top') for topic in CAMERA_TOPICS)]


@pytest.fixture(scope='module')
def bag(bench: ModuleType) -> Any:
    return bench.load_room_bag()


def replay(bench: ModuleType, bag: Any, instants: int) -> Any:
    """The first instants of the bag through depth and mapper."""
    pairs = (pair_from_projections(bag.projections['left'], bag.projections[n]) for n in ('right', 'top'))
    matcher = TrinocularDepth(*pairs, DepthSettings())
    part = replace(bag, instants=bag.instants[:instants])
    return bench.replay(part, bag.truth, SCENE, lambda instant: matcher.compute(*instant.images).depth)


@pytest.fixture(scope='module')
def run(bench: ModuleType, bag: Any) -> Any:
    return replay(bench, bag, len(bag.instants))


@pytest.fixture(scope='module')
def score(bench: ModuleType, bag: Any, run: Any) -> Any:
    assert run.frames == len(bag.instants)
    return bench.score(run.occupancy, bag.truth, bench.seen_cells(bag, bag.truth, SCENE), SCENE)


def test_truth_pictures_and_calibration_are_those_of_the_scene(bag: Any) -> None:
    cells, corner = true_map(SCENE)
    np.testing.assert_array_equal(bag.truth.occupancy, cells)
    assert (bag.truth.frame.origin_x, bag.truth.frame.origin_y) == pytest.approx(corner)
    start = bag.instants[0].stamp
    for index in (0, 70, 139):
        instant = bag.instants[index]
        true = SCENE.drive.pose_at(instant.stamp - start)
        assert (instant.truth.x, instant.truth.y, instant.truth.yaw) == pytest.approx(
            (true.x, true.y, true.yaw), abs=1e-5
        )
        rendered = SCENE.pictures(index, index / 5.0)
        for picture, view in zip(instant.images, rendered.values(), strict=True):
            assert cv2.absdiff(picture, view).mean() < 6.0
    right, top = (pair_from_projections(bag.projections['left'], bag.projections[n]) for n in ('right', 'top'))
    assert (right.axis, right.baseline, top.axis, top.baseline) == pytest.approx((0, 0.1, 1, -0.1))


def test_the_poses_are_a_localizers(bag: Any) -> None:
    start = bag.poses[0][0]
    errors = np.array([pose.distance_to(SCENE.drive.pose_at(stamp - start)) for stamp, pose in bag.poses])
    assert 0.001 < errors.mean() < 0.01


def test_what_is_occupied_in_the_map_is_solid(score: Any) -> None:
    """A depth of 3 m is off by 0.05 m for a sixth of a pixel: a cell or two."""
    assert score.precision[1] > 0.9
    assert score.precision[2] > 0.98


def test_what_was_seen_and_is_solid_is_in_the_map(score: Any) -> None:
    assert score.recall[1] > 0.93
    assert score.recall[2] > 0.97


def test_where_the_map_is_free_the_robot_does_not_collide(score: Any) -> None:
    """Half a cell is what the map can tell; under table tops some cells are free, but not their edges."""
    assert score.overlap <= 0.5 * RESOLUTION
    assert score.false_free[0] < 0.01 * score.free


def test_the_node_makes_the_same_map(bench: ModuleType, bag: Any, tmp_path: Path) -> None:
    instants = 30
    run, end = replay(bench, bag, instants), bag.instants[instants].stamp
    with BagReader(bench.BAG) as whole, BagWriter(tmp_path / 'bag') as beginning:
        for raw in whole.messages(TOPICS):
            if 1e-9 * raw.stamp_ns < end - 0.01:
                beginning.write_raw(raw.topic, raw.msgtype, raw.raw, raw.stamp_ns)
    parameters = {
        'use_sim_time': True,
        'source': 'trinocular',
        'image_transport': 'compressed',
        'camera_xyz': list(SCENE.rig.mount.xyz),
    }
    with isolated_graph() as graph, BagReader(tmp_path / 'bag') as reader:
        node = graph.add(RewardPlannerNode, **parameters)
        player = graph.node('player')
        replay_in_lockstep(reader, player, graph.executor, TOPICS)
        occupancy = node._navigator.mapper.map.occupancy_in(bag.truth.frame)
    assert (run.occupancy >= 0).sum() > 5000
    assert (occupancy != run.occupancy).mean() < 0.002
