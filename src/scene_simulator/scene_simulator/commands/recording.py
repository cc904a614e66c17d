"""Recording of a simulated drive as a rosbag2 bag: messages in the order of their stamps, and the command around it."""

import argparse
import heapq
from collections.abc import Callable, Iterable, Iterator
from operator import itemgetter
from pathlib import Path

import numpy as np
from tqdm import tqdm

from scene_simulator import messages
from scene_simulator.errors import SceneError
from scene_simulator.robot.leg_drive import TiltReading
from scene_simulator.robot.robot_drive import SensorDrive, WheelErrors, WheelReading, simulate_odometry
from shirube_bags.bag_writer import BagWriter
from shirube_bags.errors import BagError
from shirube_core.command import run_command
from shirube_core.geometry import SE2

START_NS = 1_780_000_000_000_000_000  # stamp of the first message [ns since the epoch]
Entry = tuple[int, str, str, object]  # stamp [ns], topic, message type, message
_ODOMETRY_PERIOD_NS = 20_000_000


def stamp_at(time: float) -> int:
    """Return the stamp of a time since the start [s]."""
    return START_NS + round(time * 1e9)


def write_entries(path: Path, counted: str, *sources: Iterable[Entry]) -> Iterator[int]:
    """Record messages; each is received at its own stamp, in the order of the stamps.

    Args:
        path: folder of the bag; must not exist.
        counted: topic whose messages are counted for progress display.
        sources: messages, each source sorted by stamp; of equal stamps, those of the first source come first.

    Yields:
        the number of each message of the counted topic after it is written.

    Raises:
        BagError: the bag cannot be written.
    """
    count = 0
    with BagWriter(path) as bag:
        for stamp, topic, kind, message in heapq.merge(*sources, key=itemgetter(0)):
            bag.write(topic, kind, message, stamp)
            if topic == counted:
                yield count
                count += 1


def odometry_of_drive(pose_at: Callable[[float], SE2], seconds: float, rng: np.random.Generator) -> Iterator[Entry]:
    """Yield wheel odometry with the default errors.

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
        stamp = START_NS + time_ns
        yield stamp, '/odom', 'nav_msgs/msg/Odometry', messages.odometry(pose, velocity, stamp)
        before = pose


def write_drive(path: Path, drive: SensorDrive, seconds: float, counted: str, images: Iterable[Entry]) -> Iterator[int]:
    """Record images of a drive and what its wheels and inertial unit measure; arguments and errors as `write_entries`.

    The length [s] is positive.
    """
    odometry, tilt = _odometry_entries(drive.odometry(seconds)), _imu_entries(drive.tilt_readings(seconds))
    return write_entries(path, counted, odometry, tilt, images)


def _odometry_entries(readings: Iterable[WheelReading]) -> Iterator[Entry]:
    for reading in readings:
        stamp = stamp_at(reading.time)
        message = messages.odometry(reading.pose, (reading.forward, reading.yaw_rate), stamp)
        yield stamp, '/odom', 'nav_msgs/msg/Odometry', message


def _imu_entries(readings: Iterable[TiltReading]) -> Iterator[Entry]:
    for reading in readings:
        stamp = stamp_at(reading.time)
        yield stamp, '/imu', 'sensor_msgs/msg/Imu', messages.imu(reading, 'base_link', stamp)


def bag_parser(name: str, description: str | None, seconds: float, seed: int, seed_use: str) -> argparse.ArgumentParser:
    """Return the parser of a command that records a bag: ``bag``, ``--seconds`` and ``--seed`` with its use."""
    parser = argparse.ArgumentParser(prog=name, description=description)
    parser.add_argument('bag', type=Path, help='folder of the bag to write')
    parser.add_argument('--seconds', type=float, default=seconds, help='length [s] (default: %(default)s)')
    parser.add_argument('--seed', type=int, default=seed, help=f'seed of {seed_use} (default: %(default)s)')
    return parser


def run_recording(name: str, record: Callable[[], tuple[Iterator[int], int, str]], unit: str) -> int:
    """Record a bag with a progress bar; return 0, or 1 after one line when an option or the bag is bad.

    Args:
        name: name of the command.
        record: returns the numbers of what is written, how many they will be, and the line printed at the end.
        unit: what is counted.
    """

    def work() -> None:
        written, total, line = record()
        for _ in tqdm(written, 'rendering', total, unit=unit, mininterval=1.0, delay=1.0):
            pass
        print(line)

    return run_command(name, work, (BagError, SceneError))
