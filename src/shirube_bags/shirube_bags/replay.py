"""Replays a bag once: each message at its time, or in lockstep with the nodes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from threading import Event

from shirube_bags.bag_player import BagPlayer
from shirube_bags.bag_reader import BagReader
from shirube_bags.lockstep import Lockstep
from shirube_bags.replay_clock import ReplayClock
from shirube_bags.stamps import NANOSECONDS

# ``/clock`` is published at 40 Hz between the messages, as by "ros2 bag play" [s].
CLOCK_INTERVAL = 0.025


@dataclass(frozen=True)
class ReplayResult:
    """Result of a replay.

    Attributes:
        messages: number of published messages.
        bag_duration: replayed time of the bag [s].
        elapsed: wall time of the replay [s].
    """

    messages: int
    bag_duration: float
    elapsed: float


def replay(
    bag: BagReader,
    player: BagPlayer,
    rate: float,
    lockstep: Lockstep | None,
    *,
    stop: Event,
    on_progress: Callable[[float], None],
) -> ReplayResult:
    """Publish the bag's messages once.

    Args:
        bag: open bag.
        player: player of the topics to replay.
        rate: playback rate; 0 publishes without waiting.
        lockstep: waits for the nodes after each message; None to publish without waiting for them.
        stop: event that ends the replay.
        on_progress: called with the replayed time of the bag [s].

    Raises:
        ReplayError: a node has not responded in time.
        BagError: the bag is corrupted.
    """
    began = time.monotonic()
    replay_clock = ReplayClock(rate, bag.start_ns, began)
    publish = player.publish if lockstep is None else lockstep.publish
    count, played = 0, 0.0
    for message in bag.messages(player.topics):
        wait_until_due(replay_clock, message.stamp_ns, player, stop)
        if stop.is_set():
            break
        publish(message)
        count += 1
        played = (message.stamp_ns - bag.start_ns) / NANOSECONDS
        on_progress(played)
    return ReplayResult(count, played, time.monotonic() - began)


def wait_until_due(replay_clock: ReplayClock, stamp_ns: int, player: BagPlayer, stop: Event) -> None:
    """Wait for the time of a message, while publishing ``/clock``."""
    while (delay := replay_clock.delay(stamp_ns, time.monotonic())) > 0.0:
        if stop.wait(min(delay, CLOCK_INTERVAL)):
            return
        player.set_clock(min(replay_clock.bag_time(time.monotonic()), stamp_ns))
