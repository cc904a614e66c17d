"""Loads trajectories from bags and TUM files (``stamp x y z qx qy qz qw`` per line), and saves the latter."""

import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shirube_bags.bag_reader import BagReader, BagTopic, jazzy_types
from shirube_bags.errors import BagError, TrajectoryError, TumFileError
from shirube_bags.stamps import NANOSECONDS, stamp_from_text, text_from_stamp
from shirube_bags.trajectory import Trajectory, find_malformed_pose, make_trajectory
from shirube_core.files import write_text

POSE_TYPES = (
    'geometry_msgs/msg/PoseStamped',
    'geometry_msgs/msg/PoseWithCovarianceStamped',
    'nav_msgs/msg/Odometry',
    'geometry_msgs/msg/TransformStamped',
)


def load_bag_trajectory(bag: BagReader, topic: str | None) -> Trajectory:
    """Load the poses of a topic, None for the only one, stamped by their headers; raises `BagError`."""
    chosen = select_pose_topic(bag, topic)
    stamps, positions, quaternions = [], [], []
    for message in bag.messages([chosen.name]):
        decoded = bag.decode(message)
        position, quaternion = extract_pose(decoded, chosen.msgtype)
        stamps.append(decoded.header.stamp.sec * NANOSECONDS + decoded.header.stamp.nanosec)
        positions.append((position.x, position.y, position.z))
        quaternions.append((quaternion.x, quaternion.y, quaternion.z, quaternion.w))
    try:
        return make_trajectory(stamps, positions, quaternions)
    except TrajectoryError as fault:
        raise BagError(f'{bag.path}, topic {chosen.name}: {fault}') from fault


def load_header_stamps(bag: BagReader, topic: str) -> NDArray[np.int64]:
    """Return the header stamps of a topic, shape (n,), increasing [ns]; raise a BagError if it has no headers."""
    (name,) = bag.select_topics([topic])
    msgtype = bag.topics[name].msgtype
    fields = jazzy_types().fielddefs.get(msgtype, (None, []))[1]
    if not fields or fields[0][0] != 'header':
        raise BagError(f'{bag.path}, topic {name}: {msgtype} has no header with a stamp; name another topic')
    stamps = [header_stamp(message.raw) for message in bag.messages([name])]
    return np.unique(np.array(stamps, dtype=np.int64))


def header_stamp(raw: bytes) -> int:
    """Return the header stamp [ns] of a serialized message without decoding the rest."""
    order = '<' if raw[1] else '>'
    seconds, nanoseconds = struct.unpack_from(f'{order}iI', raw, 4)
    return int(seconds) * NANOSECONDS + int(nanoseconds)


def select_pose_topic(bag: BagReader, topic: str | None) -> BagTopic:
    """Return the named topic, or the only one with poses; raise a BagError if there is no such or no unique choice."""
    with_poses = [each for each in bag.topics.values() if each.msgtype in POSE_TYPES]
    if topic is None:
        if len(with_poses) == 1:
            return with_poses[0]
        raise BagError(f'{bag.path}: {format_names(with_poses)} have poses; name one of them')
    (name,) = bag.select_topics([topic])
    chosen = bag.topics[name]
    if chosen.msgtype not in POSE_TYPES:
        raise BagError(
            f'{bag.path}, topic {name}: has type {chosen.msgtype}, not poses; {format_names(with_poses)} have poses'
        )
    return chosen


def format_names(topics: Iterable[BagTopic]) -> str:
    """Return the names of topics as a comma-separated list."""
    return ', '.join(sorted(topic.name for topic in topics)) or 'no topics'


def extract_pose(message: Any, msgtype: str) -> tuple[Any, Any]:
    """Return the position and the quaternion of a message of one of `POSE_TYPES`."""
    if msgtype == 'geometry_msgs/msg/TransformStamped':
        return message.transform.translation, message.transform.rotation
    pose = message.pose if msgtype == 'geometry_msgs/msg/PoseStamped' else message.pose.pose
    return pose.position, pose.orientation


COLUMNS = 'stamp x y z qx qy qz qw'


def load_tum(path: Path | str) -> Trajectory:
    """Load a TUM file without empty lines and those that start with ``#``; raise a TumFileError if it is malformed."""
    try:
        lines = Path(path).read_text(encoding='utf-8').splitlines()
    except (OSError, UnicodeDecodeError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else 'not a text file'
        raise TumFileError(f'{path}: cannot be read ({reason}); give a text file of lines "{COLUMNS}"') from fault
    rows: dict[int, list[float]] = {}
    numbers: list[int] = []
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith('#'):
            continue
        try:
            stamp_ns, values = parse_tum_line(line)
        except ValueError as fault:
            raise TumFileError(f'{path}, line {number}: {fault}') from fault
        if stamp_ns in rows:
            raise TumFileError(f'{path}, line {number}: duplicate stamp; keep one of the two lines')
        rows[stamp_ns] = values
        numbers.append(number)
    if not rows:
        raise TumFileError(f'{path}: has no poses; give lines "{COLUMNS}"')
    poses = np.array(list(rows.values()))
    malformed = find_malformed_pose(poses[:, :3], poses[:, 3:])
    if malformed is not None:
        raise TumFileError(f'{path}, line {numbers[malformed[0]]}: {malformed[1]}; remove such poses')
    return make_trajectory(list(rows), poses[:, :3], poses[:, 3:])


def parse_tum_line(line: str) -> tuple[int, list[float]]:
    """Return the stamp [ns] and the seven numbers of the pose in a line; raise a ValueError for other contents."""
    fields = line.split()
    if len(fields) != 8:
        raise ValueError(f'{len(fields)} fields instead of 8; write "{COLUMNS}" with blanks between')
    try:
        return stamp_from_text(fields[0]), [float(field) for field in fields[1:]]
    except ValueError as fault:
        raise ValueError(f'{fault}; write "{COLUMNS}" as numbers') from fault


def save_tum(path: Path | str, trajectory: Trajectory) -> None:
    """Write a TUM file atomically, with nanoseconds and all digits; raise a TumFileError if it cannot be written."""
    rows = zip(trajectory.stamps_ns, trajectory.positions, trajectory.quaternions, strict=True)
    lines = [f'# {COLUMNS}\n']
    for stamp_ns, position, quaternion in rows:
        numbers = ' '.join(repr(float(number)) for number in (*position, *quaternion))
        lines.append(f'{text_from_stamp(stamp_ns)} {numbers}\n')
    try:
        write_text(path, ''.join(lines))
    except OSError as fault:
        raise TumFileError(f'{path}: cannot be written ({fault.strerror}); choose a writable place') from fault
