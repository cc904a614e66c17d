"""Lockstep replay: a message is published when the nodes have processed the last one.

No message is lost, however slow the nodes and short their queues, and the replay runs as fast as possible.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rclpy.executors import Executor
from rclpy.node import Node

from shirube_bags.bag_player import CLOCK, BagPlayer
from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_bags.node_barrier import NodeBarrier

# A message in one datagram arrives before a request sent after it; fragments may be overtaken [byte].
LARGEST_DATAGRAM = 65_000
# The first message may start a compilation of numba kernels in the node [s].
RESPONSE_TIMEOUT = 180.0
# With middleware settings other than those of ``play``, an acknowledgement can take seconds [s].
ACK_TIMEOUT = 0.1


class Lockstep:
    """Publishes messages and waits until all subscribing nodes have processed them."""

    def __init__(
        self,
        player: BagPlayer,
        node: Node,
        executor: Executor,
        timeout: float = RESPONSE_TIMEOUT,
        should_stop: Callable[[], bool] = lambda: False,
    ) -> None:
        """Start without known subscribers.

        Args:
            player: player that publishes the messages.
            node: node of the player.
            executor: executor of this node; it may contain the nodes under test, too.
            timeout: longest processing time of one message [s].
            should_stop: polled while waiting; True ends the wait.
        """
        self._player = player
        self._timeout = timeout
        self._barrier = NodeBarrier(node, executor, should_stop)
        self._subscribers: dict[str, tuple[int, tuple[str, ...]]] = {}

    @property
    def nodes_without_services(self) -> tuple[str, ...]:
        """Subscribing nodes without a parameter service, which cannot be waited for; known after `wait`."""
        return self._barrier.nodes_without_services

    def publish(self, message: BagMessage) -> None:
        """Publish a message and wait until it is processed.

        Raises:
            ReplayError: a node has not responded in time.
        """
        # Executors poll one subscription after the other: without this barrier, the message could be taken in a poll
        # that missed the clock just before it.
        self._player.set_clock(message.stamp_ns)
        clock_subscribers = set(self._subscribers_of(CLOCK)) & set(self._subscribers_of(message.topic))
        self._barrier.wait_for_nodes(sorted(clock_subscribers), self._timeout)
        self._player.publish(message)
        if len(message.raw) > LARGEST_DATAGRAM:
            self._player.wait_until_received([message.topic], ACK_TIMEOUT)
        self.wait([message.topic])

    def wait(self, topics: Sequence[str]) -> None:
        """Wait until all messages published on the topics are processed.

        Raises:
            ReplayError: a node has not responded in time.
        """
        names = {name for topic in topics for name in self._subscribers_of(topic)}
        # Executors poll subscriptions before services: if both arrive in between, the request is served first. The
        # second request is served after another poll of the subscriptions.
        for _ in range(2):
            self._barrier.wait_for_nodes(sorted(names), self._timeout)

    def _subscribers_of(self, topic: str) -> tuple[str, ...]:
        count = self._player.subscriber_count(topic)
        known_count, names = self._subscribers.get(topic, (0, ()))
        if count != known_count:
            names = self._barrier.find_subscribers(self._player.resolve_topic(topic), count)
            self._subscribers[topic] = (count, names)
        return names if count else ()


def replay_in_lockstep(
    bag: BagReader,
    node: Node,
    executor: Executor,
    topics: Sequence[str] = (),
    timeout: float = RESPONSE_TIMEOUT,
) -> int:
    """Replay a bag in lockstep, for tests with all nodes in one process.

    Args:
        bag: open bag.
        node: node of the player.
        executor: executor of this node and of all nodes under test, in one context.
        topics: topics to replay; all if empty.
        timeout: longest processing time of one message [s].

    Returns:
        number of published messages.

    Raises:
        ReplayError: a type is not installed, or a node has not responded in time.
        BagError: a topic is not in the bag, or the bag is corrupted.
    """
    player = BagPlayer(node, [bag.topics[topic] for topic in bag.select_topics(topics)])
    lockstep = Lockstep(player, node, executor, timeout)
    lockstep.wait(player.topics)
    count = 0
    for message in bag.messages(player.topics):
        lockstep.publish(message)
        count += 1
    return count
