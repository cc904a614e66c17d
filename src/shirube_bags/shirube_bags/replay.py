"""One round of a replay: each message at its time, or in step with the nodes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from threading import Event

from shirube_bags.bag_player import BagPlayer
from shirube_bags.bag_reader import BagReader
from shirube_bags.lockstep import Lockstep
from shirube_bags.replay_pace import ReplayPace
from shirube_bags.stamps import NANOSECONDS

# ``/clock`` goes on at 40 Hz between the messages, as that of "ros2 bag play" [s].
CLOCK_INTERVAL = 0.025


@dataclass(frozen=True)
class ReplayOutcome:
    """What was replayed.

    Attributes:
        messages: how many were published.
        bag_duration: the bag's time that was played [s].
        took: the time it took [s].
    """

    messages: int
    bag_duration: float
    took: float


def replay(
    bag: BagReader,
    player: BagPlayer,
    rate: float,
    lockstep: Lockstep | None,
    *,
    stop: Event,
    on_progress: Callable[[float], None],
) -> ReplayOutcome:
    """Publish the bag's messages once.

    Args:
        bag: an open bag.
        player: publishes; its topics are replayed.
        rate: seconds of the bag a second; 0 waits for no time at all.
        lockstep: waits for the nodes after each message; None does not.
        stop: ends the replay when it is set.
        on_progress: told the bag's time since its start [s].

    Raises:
        ReplayError: a node has not answered in time.
        BagError: the bag is damaged.
    """
    began = time.monotonic()
    pace = ReplayPace(rate, bag.start_ns, began)
    publish = player.publish if lockstep is None else lockstep.publish
    count, played = 0, 0.0
    for message in bag.messages(player.topics):
        wait_until_due(pace, message.stamp_ns, player, stop)
        if stop.is_set():
            break
        publish(message)
        count += 1
        played = (message.stamp_ns - bag.start_ns) / NANOSECONDS
        on_progress(played)
    return ReplayOutcome(count, played, time.monotonic() - began)


def wait_until_due(pace: ReplayPace, stamp_ns: int, player: BagPlayer, stop: Event) -> None:
    """Wait for the time of a message, while ``/clock`` goes on."""
    while (delay := pace.delay(stamp_ns, time.monotonic())) > 0.0:
        if stop.wait(min(delay, CLOCK_INTERVAL)):
            return
        player.set_clock(min(pace.bag_time(time.monotonic()), stamp_ns))
