"""Loads trajectories and header stamps from bags."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shirube_bags.bag_reader import BagReader, BagTopic
from shirube_bags.errors import BagError, TrajectoryError
from shirube_bags.message_types import jazzy_types
from shirube_bags.stamps import NANOSECONDS
from shirube_bags.trajectory import Trajectory, make_trajectory

POSE_TYPES = (
    'geometry_msgs/msg/PoseStamped',
    'geometry_msgs/msg/PoseWithCovarianceStamped',
    'nav_msgs/msg/Odometry',
    'geometry_msgs/msg/TransformStamped',
)


def load_bag_trajectory(bag: BagReader, topic: str | None) -> Trajectory:
    """Load the poses of one topic, stamped by their headers.

    Args:
        bag: open bag.
        topic: topic name; None selects the only topic with poses.

    Raises:
        BagError: no such topic, an ambiguous choice, another type, or malformed poses.
    """
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
    """Return the header stamps of a topic's messages, shape (n,), increasing [ns].

    Raises:
        BagError: no such topic, or its messages have no header.
    """
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
    """Return the named topic, or the only one with poses.

    Raises:
        BagError: no such topic, an ambiguous choice, or a topic without poses.
    """
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
