"""The recorded images of the mission through the localizers: each gives the pose or reports why not."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from node_testing import poses_in

from floor_localizer.commands.locate import locate_bag as locate_floor
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.tracker import FloorTracker
from scene_simulator.commands.lamps import write_beacons
from scene_simulator.mission.layout import (
    BELLY_MOUNT,
    CARPET,
    CEILING_CAMERA,
    CEILING_MOUNT,
    LAMP_RADIUS,
    LAMP_RATE,
    LAMPS,
    surveyed_floor,
)
from scene_simulator.mission.sensors import STEREO_RIG
from shirube_bags.bag_reader import BagReader
from shirube_bringup.building import teach_places
from shirube_core.geometry import SE2
from shirube_ros.offline.recording import choose_topics as floor_topics
from stereo_landmark.commands.locate import locate_bag as locate_landmarks
from stereo_landmark.core.pair.pair_stream import PairStream
from stereo_landmark.core.settings import LandmarkSettings, PairSettings
from stereo_landmark.files.camera_files import choose_topics as pair_topics
from stereo_landmark.files.place_file import load_places
from vlc_beacon.commands.locate import locate as locate_lamps
from vlc_beacon.commands.locate import make_parser as lamp_options

BAG = Path(__file__).parents[1] / 'bags' / 'mission'
Poses = dict[int, SE2]


@pytest.fixture(scope='module')
def truth() -> Callable[[int], SE2]:
    """Where the robot truly was, by stamp [ns]; it is told every 20 ms."""
    with BagReader(BAG) as bag:
        return poses_in(bag, '/ground_truth').__getitem__


def errors(poses: Poses, truth: Callable[[int], SE2]) -> tuple[np.ndarray, np.ndarray]:
    """Return how far poses are off [m], and how far turned [rad]."""
    pairs = [(pose, truth(stamp)) for stamp, pose in poses.items()]
    places = np.array([pose.distance_to(true) for pose, true in pairs])
    return places, np.abs([true.yaw_to(pose) for pose, true in pairs])


@pytest.mark.timeout(300)
def test_the_floor_is_read_to_a_tenth_of_a_millimetre_and_the_carpet_is_not(truth: Callable[[int], SE2]) -> None:
    floor = surveyed_floor()
    localizer = FloorLocalizer(index_map(DotMap(floor.points, floor.diameters)), BELLY_MOUNT)
    with BagReader(BAG) as bag:
        topics = floor_topics(bag, '/floor/image_raw/compressed', '/floor/camera_info', None)
        images = list(locate_floor(bag, topics, lambda: FloorTracker(localizer)))
    assert len(images) == 200
    poses = {i.stamp_ns: i.result.T_map_base for i in images if isinstance(i.result, Fix)}
    places, turns = errors(poses, truth)
    assert places.max() < 3e-4
    assert turns.max() < math.radians(0.3)
    inside = {i.stamp_ns for i in images if is_on_the_carpet(truth(i.stamp_ns))}
    assert inside
    assert len(poses.keys() & inside) <= 0.1 * len(inside)
    outside = [i.stamp_ns for i in images if is_clear_of_the_carpet(truth(i.stamp_ns))]
    assert outside
    assert len(poses.keys() & set(outside)) >= 0.95 * len(outside)


def is_on_the_carpet(pose: SE2) -> bool:
    """Return whether the belly camera sees nothing but carpet."""
    (left, low), (right, high) = CARPET.low, CARPET.high
    return left + 0.3 < pose.x < right - 0.3 and low + 0.3 < pose.y < high - 0.3


def is_clear_of_the_carpet(pose: SE2) -> bool:
    """Return whether the belly camera sees no carpet."""
    (left, low), (right, high) = CARPET.low, CARPET.high
    return not (left - 0.3 < pose.x < right + 0.3 and low - 0.3 < pose.y < high + 0.3)


@pytest.mark.timeout(300)
def test_lamps_give_the_pose_to_centimetres(truth: Callable[[int], SE2], tmp_path: Path) -> None:
    beacons = tmp_path / 'beacons.yaml'
    write_beacons(list(LAMPS.items()), LAMP_RADIUS, beacons)
    shutter, mount = CEILING_CAMERA.shutter, CEILING_MOUNT
    words = [
        *('--beacons', str(beacons), '--bag', str(BAG), '--out', str(tmp_path)),
        *('--topic', '/ceiling/image_raw/compressed', '--camera-info-topic', '/ceiling/camera_info'),
        *('--camera-xyz', *map(str, mount.xyz), '--camera-rpy', *map(str, mount.rpy)),
        *('--shutter', 'rolling', '--exposure-time', str(shutter.exposure)),
        *('--row-time', str(shutter.row_time), '--lamp-frame-rate', str(LAMP_RATE), '--camera-height-known'),
    ]
    images = locate_lamps(lamp_options().parse_args(words))
    assert len(images) == 250
    poses = {image.stamp_ns: image.fix.T_map_base for image in images if image.fix is not None}
    assert len(poses) > 0.7 * len(images)
    places, turns = errors(poses, truth)
    assert np.median(places) < 0.01
    assert places.max() < 0.08
    assert turns.max() < math.radians(2.0)


@pytest.mark.timeout(600)
def test_landmarks_give_the_pose_to_a_centimetre(truth: Callable[[int], SE2], tmp_path: Path) -> None:
    teach_places(tmp_path)
    places = list(load_places(tmp_path))
    with BagReader(BAG) as bag:
        settings, topics = (PairSettings(), LandmarkSettings()), pair_topics(bag, {}, is_raw=False)
        frames = list(locate_landmarks(bag, topics, lambda: PairStream(places, STEREO_RIG.mount, *settings)))
    assert len(frames) == 20
    fixes = {frame.stamp_ns: frame.fix for frame in frames if frame.fix is not None}
    poses = {stamp: fix.T_map_base for stamp, fix in fixes.items() if fix.T_map_base is not None}
    assert len(poses) >= 5
    off, turns = errors(poses, truth)
    assert off.max() < 0.02
    assert turns.max() < math.radians(0.5)
