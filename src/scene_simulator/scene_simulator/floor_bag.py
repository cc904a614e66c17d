"""Records the demo drive as a rosbag2 bag, with ground truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from scene_simulator import scene_messages
from scene_simulator.demo_scene import DemoScene
from scene_simulator.errors import SceneError
from scene_simulator.wheel_odometry import WheelErrors, simulate_odometry
from shirube_bags.bag_writer import BagWriter
from shirube_core.geometry import SE2

CAMERA_FRAME = 'belly_camera_optical_frame'

START_NS = 1_780_000_000_000_000_000
"""Stamp of the first message [ns since the epoch]."""

DIRTY_FRACTION = 0.05
"""An image is marked dirty when dirt hides more than this fraction of the view, twice the area of its chips."""

_IMAGE_NOISE, _WHEEL_NOISE = 1, 2
_IMAGE_PERIOD_NS = 100_000_000
_ODOMETRY_PERIOD_NS = 20_000_000


def record_drive(scene: DemoScene, path: Path, seconds: float) -> Iterator[int]:
    """Record a drive; every message is received at its own stamp, in the order of the stamps.

    Args:
        scene: what to record.
        path: folder of the bag; must not exist.
        seconds: length of the recording [s].

    Yields:
        the number of each image after it is written, for progress display.

    Raises:
        BagError: the bag cannot be written.
        SceneError: the length is not positive.
    """
    times = _image_times(seconds)
    with BagWriter(path) as bag:
        rng = np.random.default_rng((scene.seed, _WHEEL_NOISE))
        odometry = odometry_messages(scene.pose_at, seconds, rng)
        pending = next(odometry, None)
        for index, time_ns in enumerate(times):
            while pending is not None and pending[0] <= time_ns:
                bag.write('/odom', 'nav_msgs/msg/Odometry', pending[1], START_NS + pending[0])
                pending = next(odometry, None)
            _write_image(bag, scene, index, time_ns)
            yield index
        while pending is not None:
            bag.write('/odom', 'nav_msgs/msg/Odometry', pending[1], START_NS + pending[0])
            pending = next(odometry, None)


def image_count(seconds: float) -> int:
    """Return the number of images in a recording of this length [s].

    Raises:
        SceneError: the length is not positive.
    """
    return len(_image_times(seconds))


def _image_times(seconds: float) -> range:
    """Return the times of the images since the start [ns], or raise SceneError where there is none."""
    if not 0.0 < seconds < math.inf:
        raise SceneError(f'the recording is {seconds} s long: give a positive number of seconds')
    return range(0, round(seconds * 1e9), _IMAGE_PERIOD_NS)


def _write_image(bag: BagWriter, scene: DemoScene, index: int, time_ns: int) -> None:
    """Write an image with its calibration, the true pose at the middle of its exposure and its dirt mark."""
    stamp = START_NS + time_ns
    photo = scene.photograph(time_ns / 1e9, np.random.default_rng((scene.seed, _IMAGE_NOISE, index)))
    truth = scene_messages.pose_stamped(scene.pose_at(time_ns / 1e9), 'map', stamp)
    dirty = scene_messages.flag(photo.dirt_fraction > DIRTY_FRACTION)
    info = scene_messages.camera_info(scene.camera.intrinsics, CAMERA_FRAME, stamp)
    image = scene_messages.compressed_image(photo.image, CAMERA_FRAME, stamp)
    bag.write('/ground_truth', 'geometry_msgs/msg/PoseStamped', truth, stamp)
    bag.write('/dirt', 'std_msgs/msg/Bool', dirty, stamp)
    bag.write('/camera_info', 'sensor_msgs/msg/CameraInfo', info, stamp)
    bag.write('/image_raw/compressed', 'sensor_msgs/msg/CompressedImage', image, stamp)


def odometry_messages(
    pose_at: Callable[[float], SE2], seconds: float, rng: np.random.Generator
) -> Iterator[tuple[int, object]]:
    """Yield wheel odometry, each message with its time since the start [ns].

    Args:
        pose_at: gives ``T_map_base`` at a time since the start [s].
        seconds: length of the recording [s].
        rng: source of the wheels' slip.
    """
    times_ns = range(0, round(seconds * 1e9), _ODOMETRY_PERIOD_NS)
    true_poses = [pose_at(time_ns / 1e9) for time_ns in times_ns]
    before = None
    for time_ns, pose in zip(times_ns, simulate_odometry(true_poses, WheelErrors(), rng), strict=True):
        motion = (before or pose).inverse() @ pose
        velocity = (motion.x * 1e9 / _ODOMETRY_PERIOD_NS, motion.yaw * 1e9 / _ODOMETRY_PERIOD_NS)
        yield time_ns, scene_messages.odometry(pose, velocity, START_NS + time_ns)
        before = pose
