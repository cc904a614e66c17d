"""Waits for the subscribers of a replay."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

from shirube_bags.errors import ReplayError

# After the first subscriber, the other subscriptions of the same node are discovered within this time [s].
SETTLING_TIME = 0.3
POLL_INTERVAL = 0.01


def wait_for_counts(
    subscriber_count: Callable[[str], int],
    wanted: Mapping[str, int],
    timeout: float,
    should_stop: Callable[[], bool],
) -> None:
    """Wait until each topic has the requested number of subscribers.

    Args:
        subscriber_count: returns the number of subscribers of a topic.
        wanted: requested number of subscribers by topic.
        timeout: longest wait for all subscribers [s].
        should_stop: polled while waiting; True ends the wait.

    Raises:
        ReplayError: timeout.
    """
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
    subscriber_count: Callable[[str], int],
    topics: Sequence[str],
    timeout: float,
    should_stop: Callable[[], bool],
) -> list[str]:
    """Wait until a topic has a subscriber and the numbers of subscribers are stable.

    Args:
        subscriber_count: returns the number of subscribers of a topic.
        topics: replayed topics.
        timeout: longest wait for the first subscriber [s].
        should_stop: polled while waiting; True ends the wait.

    Returns:
        topics without a subscriber.
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
