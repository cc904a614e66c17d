"""The lidar baseline of the lamp benchmarks: it finds the true pose, and furniture occludes its beams."""

import importlib
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from shirube_core.geometry import SE2

pytestmark = pytest.mark.newest_set_only

BENCHMARKS = Path(__file__).resolve().parents[1] / 'benchmarks'
SHELF_HEIGHT = 1.8


@pytest.fixture(scope='module', autouse=True)
def benchmarks() -> Iterator[None]:
    """Lets the benchmarks be imported."""
    sys.path.insert(0, str(BENCHMARKS))
    yield
    sys.path.remove(str(BENCHMARKS))


@pytest.fixture(scope='module')
def rooms() -> ModuleType:
    return importlib.import_module('_lidar_room')


@pytest.fixture(scope='module')
def matching() -> ModuleType:
    return importlib.import_module('_lidar_matcher')


def test_an_empty_room_is_scanned_to_its_walls(rooms: ModuleType) -> None:
    scan = rooms.FurnishedRoom(()).scan(SE2(*rooms.MIDDLE, 0.0), np.random.default_rng(1))
    ranges = np.hypot(scan[:, 0], scan[:, 1])
    quarter = rooms.BEAMS // 4
    assert ranges[[0, quarter, 2 * quarter, 3 * quarter]] == pytest.approx([3.5, 3.0, 3.5, 3.0], abs=0.05)
    cosines, sines = np.maximum(np.abs(scan.T / ranges), 1e-9)
    walls = np.minimum(3.5 / cosines, 3.0 / sines)
    assert np.std(ranges - walls) < 0.012


def test_furniture_blocks_its_beams(rooms: ModuleType) -> None:
    box = rooms.Furniture(SE2(rooms.MIDDLE[0] + 1.0, rooms.MIDDLE[1], 0.3), (0.4, 0.4), 0.9)
    scan = rooms.FurnishedRoom((box,)).scan(SE2(*rooms.MIDDLE, math.pi), np.random.default_rng(1))
    assert 0.7 < np.hypot(*scan[rooms.BEAMS // 2]) < 0.85
    assert np.hypot(*scan[0]) == pytest.approx(3.5, abs=0.05)


def test_scans_are_matched_with_the_map_of_the_same_room(rooms: ModuleType, matching: ModuleType) -> None:
    rng = np.random.default_rng(3)
    room = rooms.furnished_room(rng)
    places = [SE2(*rng.uniform(-1.5, 3.0, 2), rng.uniform(-3.0, 3.0)) for _ in range(200)]
    free = [pose for pose in places if room.is_free(pose)]
    matcher = matching.ScanMatcher((pose, room.scan(pose, rng)) for pose in free[:40])
    for pose in free[40:50]:
        found = matcher.match(room.scan(pose, rng), pose @ SE2(0.07, -0.07, 0.08))
        assert found is not None
        assert found.distance_to(pose) < 0.005
        assert abs(found.yaw_to(pose)) < 0.002


def test_slam_follows_a_drive_with_wrong_odometry_and_its_map_is_used_again(
    rooms: ModuleType, matching: ModuleType
) -> None:
    rng = np.random.default_rng(4)
    room = rooms.FurnishedRoom(())
    path = [SE2(0.05 * k, 0.9, 0.01 * k) for k in range(40)]
    slam = matching.LidarSlam(path[0])
    for start in (path[0], path[0] @ SE2(0.05, -0.05, 0.05)):
        before, slam = start, slam.restarted(start) if start is not path[0] else slam
        for pose in path:
            motion = before.inverse() @ pose
            found = slam.track(SE2(1.05 * motion.x, motion.y, 1.05 * motion.yaw), room.scan(pose, rng))
            before = pose
        assert found.distance_to(path[-1]) < 0.01


def test_racks_hide_lamps_behind_them_and_low_ones_do_not(rooms: ModuleType) -> None:
    camera = SE2(-1.0, 0.0, 0.5)
    shelf = SE2(-0.7, 0.0, math.pi / 2.0)
    for height, hidden in ((SHELF_HEIGHT, True), (0.4, False)):
        hides = rooms.FurnishedRoom((rooms.Furniture(shelf, (0.5, 0.2), height),)).occluded_lamps(camera)
        assert hides[0] == hidden
        assert not hides[1]
