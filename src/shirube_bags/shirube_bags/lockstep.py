"""Lockstep replay: a message is published when the nodes have processed the last one."""

import time
from collections.abc import Callable, Iterable, Sequence

from rcl_interfaces.srv import GetParameters
from rclpy.client import Client
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.task import Future
from rclpy.topic_endpoint_info import TopicEndpointInfo

from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_bags.errors import ReplayError
from shirube_bags.ros_session import CLOCK, BagPlayer

# Discovery of a node's services takes milliseconds after that of its subscriptions, sometimes seconds [s].
DISCOVERY_TIMEOUT = 3.0
# A response sent before the client is discovered can be lost, so requests are repeated [s].
REPEAT_INTERVAL = 1.0


class NodeBarrier:
    """Finds the nodes that subscribe to topics, and waits until they have responded."""

    def __init__(self, node: Node, executor: Executor, should_stop: Callable[[], bool]) -> None:
        """Start without clients; ``should_stop`` is polled while waiting, the executor spins ``node`` and others."""
        self._node = node
        self._executor = executor
        self._should_stop = should_stop
        self._clients: dict[str, Client] = {}
        self._without_services: set[str] = set()

    @property
    def nodes_without_services(self) -> tuple[str, ...]:
        """Nodes without a parameter service, which cannot be waited for."""
        return tuple(sorted(self._without_services))

    def find_subscribers(self, topic: str, count: int) -> tuple[str, ...]:
        """Return the full names of the nodes that subscribe to a topic, waiting until ``count`` are discovered."""
        deadline = time.monotonic() + DISCOVERY_TIMEOUT
        while True:
            found = self._node.get_subscriptions_info_by_topic(topic)
            names = {full_name(each) for each in found if 'UNKNOWN' not in each.node_name}
            if (len(found) == count and len(names) > 0) or time.monotonic() > deadline or self._should_stop():
                return tuple(sorted(names))
            self._executor.spin_once(timeout_sec=0.01)

    def wait_for_nodes(self, names: Iterable[str], timeout: float) -> None:
        """Wait until the nodes, by full name, have responded; nodes that have ended or are unresponsive are
        skipped.

        Raises:
            ReplayError: no response within the timeout [s].
        """
        responses = {name: self._request(name) for name in names if self._is_available(name)}
        now = time.monotonic()
        deadline, repeat = now + timeout, now + REPEAT_INTERVAL
        while (pending := self._pending(responses)) and not self._should_stop():
            now = time.monotonic()
            if now > deadline:
                raise ReplayError(f'{", ".join(pending)} has not responded for {timeout:g} s; check whether it hangs')
            if now > repeat:
                responses.update({name: self._request(name) for name in pending})
                repeat = now + REPEAT_INTERVAL
            self._executor.spin_once(timeout_sec=0.1)

    def _request(self, name: str) -> Future:
        return self._clients[name].call_async(GetParameters.Request())

    def _pending(self, responses: dict[str, Future]) -> list[str]:
        return [
            name
            for name, response in responses.items()
            if not response.done() and self._clients[name].service_is_ready()
        ]

    def _is_available(self, name: str) -> bool:
        if name in self._without_services:
            return False
        if name not in self._clients:
            self._clients[name] = self._node.create_client(GetParameters, f'{name}/get_parameters')
            deadline = time.monotonic() + DISCOVERY_TIMEOUT
            while not self._clients[name].service_is_ready() and not self._should_stop():
                if time.monotonic() > deadline:
                    self._without_services.add(name)
                    break
                self._executor.spin_once(timeout_sec=0.01)
        return bool(self._clients[name].service_is_ready())


def full_name(endpoint: TopicEndpointInfo) -> str:
    """Return the fully qualified name of an endpoint's node."""
    return f'{endpoint.node_namespace.rstrip("/")}/{endpoint.node_name}'


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
        """Start without known subscribers; the timeout is the longest processing time of one message [s]."""
        self._player = player
        self._timeout = timeout
        self._barrier = NodeBarrier(node, executor, should_stop)
        self._subscribers: dict[str, tuple[int, tuple[str, ...]]] = {}

    @property
    def nodes_without_services(self) -> tuple[str, ...]:
        """Subscribing nodes without a parameter service, which cannot be waited for; known after `wait`."""
        return self._barrier.nodes_without_services

    def publish(self, message: BagMessage) -> None:
        """Publish a message and wait until it is processed; raise a ReplayError if a node has not responded in time."""
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
        """Wait until all messages published on the topics are processed; raise a ReplayError as `publish` does."""
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
    bag: BagReader, node: Node, executor: Executor, topics: Sequence[str] = (), timeout: float = RESPONSE_TIMEOUT
) -> int:
    """Replay topics of an open bag (all if empty) in lockstep and return the number of messages.

    For tests with all nodes in one process: the executor has the player's node and all nodes under test. The timeout is
    that of one message [s]. Raises a ReplayError or BagError as `Lockstep` and `BagReader` do.
    """
    player = BagPlayer(node, [bag.topics[topic] for topic in bag.select_topics(topics)])
    lockstep = Lockstep(player, node, executor, timeout)
    lockstep.wait(player.topics)
    count = 0
    for message in bag.messages(player.topics):
        lockstep.publish(message)
        count += 1
    return count
