"""A recorded drive through the arbiter, as its node would see it: messages in, the pose at given stamps out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from _arbiter_bags import PoseSample

from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.kalman_filter import Estimate
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from shirube_core.geometry import SE2

Message = tuple[int, int, PoseSample | SE2]
"""Stamp [ns], source index or `ODOMETRY`, and the measurement."""
ODOMETRY = 1000


def messages_of(
    samples: Sequence[Sequence[PoseSample]], odometry: Sequence[tuple[int, SE2]]
) -> list[Message]:
    """Return the messages of some sources and of odometry in the order of their stamps."""
    content: list[Message] = [(o.stamp, number, o) for number, source in enumerate(samples) for o in source]
    content += [(stamp, ODOMETRY, pose) for stamp, pose in odometry]
    return sorted(content, key=lambda message: (message[0], -message[1]))


def new_arbiter(sources: int, settings: ArbiterSettings | None = None) -> Arbiter:
    """Return an arbiter with default settings for a number of sources."""
    return Arbiter((SourceSettings(),) * sources, settings or ArbiterSettings())


def add_message(arbiter: Arbiter, message: Message, now: int) -> None:
    """Add a message to an arbiter.

    Raises:
        ValueError: the arbiter rejected it.
    """
    stamp, source, content = message
    if isinstance(content, SE2):
        refusal = arbiter.add_odometry(stamp, content, now)
    else:
        refusal = arbiter.add_pose(source, stamp, content.pose, content.noise, now)
    if refusal is not None:
        raise ValueError(f'{source} at {stamp}: {refusal.value}')


def in_order_of_arrival(
    messages: Sequence[Message], delay_of: Callable[[int], int]
) -> list[tuple[int, Message]]:
    """Return messages with their times of arrival [ns], sorted by these; a source's poses are late, odometry is not."""
    arrivals = [(m[0] + (0 if m[1] == ODOMETRY else delay_of(m[1])), m) for m in messages]
    return sorted(arrivals, key=lambda each: each[0])


def fused(messages: Sequence[Message], sources: int, wanted: int) -> list[tuple[int, SE2]]:
    """Return stamp and pose right after each message of the wanted source, where there is one."""
    arbiter, poses = new_arbiter(sources), []
    for message in messages:
        add_message(arbiter, message, message[0])
        if message[1] == wanted and (estimate := arbiter.estimate_at(message[0])) is not None:
            poses.append((message[0], pose_of(estimate)))
    return poses


def pose_of(estimate: Estimate) -> SE2:
    """Return ``T_map_base`` of an estimate."""
    return SE2(estimate.x, estimate.y, estimate.yaw)
