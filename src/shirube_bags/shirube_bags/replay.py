"""Replays a bag once: each message at its time, or in lockstep with the nodes."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from threading import Event

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import ReplayError
from shirube_bags.lockstep import Lockstep
from shirube_bags.ros_session import BagPlayer
from shirube_bags.stamps import NANOSECONDS

# After the first subscriber, the other subscriptions of the same node are discovered within this time [s].
SETTLING_TIME = 0.3
POLL_INTERVAL = 0.01
# ``/clock`` is published at 40 Hz between the messages, as by "ros2 bag play" [s].
CLOCK_INTERVAL = 0.025


class ReplayClock:
    """Maps the time of the bag to a steady clock.

    A replay that fell behind, because of load or a suspended process, does not catch up: subscribers with short queues
    would lose messages of a burst. The remaining messages are delayed instead.
    """

    # A longer delay is not caught up; shorter ones are normal scheduling jitter [s].
    CATCH_UP_MAX = 0.02

    def __init__(self, rate: float, first_stamp_ns: int, now: float) -> None:
        """Start at a time ``now`` of the steady clock [s], the first stamp; rate 0 makes all messages due at once."""
        self._rate = rate
        self._first_stamp_ns = first_stamp_ns
        self._began = now

    def delay(self, stamp_ns: int, now: float) -> float:
        """Return the delay until a message is due [s], 0 or more."""
        if self._rate == 0.0:
            return 0.0
        due = self._began + (stamp_ns - self._first_stamp_ns) / NANOSECONDS / self._rate
        if now - due > self.CATCH_UP_MAX:
            self._began += now - due
        return max(0.0, due - now)

    def pause(self, duration: float) -> None:
        """Make all further messages due later by a duration [s]."""
        self._began += duration

    def bag_time(self, now: float) -> int:
        """Return the time of the bag [ns] at a time of the steady clock [s]."""
        return self._first_stamp_ns + round((now - self._began) * self._rate * NANOSECONDS)


def wait_for_counts(
    subscriber_count: Callable[[str], int], wanted: Mapping[str, int], timeout: float, should_stop: Callable[[], bool]
) -> None:
    """Wait for the wanted numbers of subscribers, at most a timeout [s]; raise a ReplayError if some are missing."""
    deadline = time.monotonic() + timeout
    while not should_stop():
        missing = {topic: count for topic, count in wanted.items() if subscriber_count(topic) < count}
        if not missing:
            return
        if time.monotonic() > deadline:
            lines = [f'{topic} has {subscriber_count(topic)} of {count}' for topic, count in missing.items()]
            raise ReplayError(
                f'subscribers are missing after {timeout:g} s: {", ".join(lines)}; '
                'start the nodes first, or compare their topics and ROS_DOMAIN_ID'
            )
        time.sleep(POLL_INTERVAL)


def wait_for_any(
    subscriber_count: Callable[[str], int], topics: Sequence[str], timeout: float, should_stop: Callable[[], bool]
) -> list[str]:
    """Wait until a topic has a subscriber and their numbers are stable; return the topics without a
    subscriber.

    The timeout [s] is that of the first subscriber; ``should_stop`` ends the wait.
    """
    now = time.monotonic()
    deadline, changed, former = now + timeout, now, [0] * len(topics)
    while not should_stop():
        counts = [subscriber_count(topic) for topic in topics]
        now = time.monotonic()
        if counts != former:
            changed, former = now, counts
        if now > deadline if not any(counts) else now > changed + SETTLING_TIME:
            break
        time.sleep(POLL_INTERVAL)
    return [topic for topic in topics if subscriber_count(topic) == 0]


@dataclass(frozen=True)
class ReplayResult:
    """Number of published messages, replayed time of the bag [s] and wall time [s]."""

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
    start_offset: float = 0.0,
    is_paused: Callable[[], bool] = lambda: False,
) -> ReplayResult:
    """Publish the messages of an open bag once, until the event ``stop``.

    Args:
        bag: open bag.
        player: player of the topics to replay.
        rate: playback rate; 0 publishes without waiting.
        lockstep: waits for the nodes after each message; None to publish without waiting for them.
        stop: event that ends the replay.
        on_progress: called with the replayed time of the bag [s].
        start_offset: time of the bag that is left out [s].
        is_paused: asked before each message; the replay goes on when it returns False.
    """
    began = time.monotonic()
    start_ns = bag.start_ns + round(start_offset * NANOSECONDS)
    replay_clock = ReplayClock(rate, start_ns, began)
    publish = player.publish if lockstep is None else lockstep.publish
    count, played = 0, 0.0
    whole = start_offset == 0.0  # only then the number of messages is checked
    messages = bag.messages(player.topics) if whole else bag.messages_between(player.topics, start_ns, bag.end_ns)
    for message in messages:
        wait_until_due(replay_clock, message.stamp_ns, player, stop, is_paused)
        if stop.is_set():
            break
        publish(message)
        count += 1
        played = (message.stamp_ns - start_ns) / NANOSECONDS
        on_progress(played)
    return ReplayResult(count, played, time.monotonic() - began)


def wait_until_due(
    replay_clock: ReplayClock, stamp_ns: int, player: BagPlayer, stop: Event, is_paused: Callable[[], bool]
) -> None:
    """Wait for the time of a message, while publishing ``/clock``, which keeps its time during a pause."""
    while not stop.is_set():
        now = time.monotonic()
        if is_paused():
            stop.wait(CLOCK_INTERVAL)
            replay_clock.pause(time.monotonic() - now)
        elif (delay := replay_clock.delay(stamp_ns, now)) > 0.0:
            stop.wait(min(delay, CLOCK_INTERVAL))
            player.set_clock(min(replay_clock.bag_time(time.monotonic()), stamp_ns))
        else:
            return
