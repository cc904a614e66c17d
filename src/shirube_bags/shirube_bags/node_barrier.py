"""A barrier for nodes: two parameter requests, after which all earlier messages are processed.

Every node serves parameter requests, in the same executor as its messages. An executor polls its subscriptions, then
its services, and processes messages before requests. A message and a request that arrive between the two polls are
processed in the wrong order; but before a second request is taken, the subscriptions are polled again. So each node
gets two GetParameters requests for no parameters. This works for nodes with the standard executors and callback groups;
a node that processes messages in its own threads responds too early.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from rcl_interfaces.srv import GetParameters
from rclpy.client import Client
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.task import Future
from rclpy.topic_endpoint_info import TopicEndpointInfo

from shirube_bags.errors import ReplayError

# Discovery of a node's services takes milliseconds after that of its subscriptions, sometimes seconds [s].
DISCOVERY_TIMEOUT = 3.0
# A response sent before the client is discovered can be lost, so requests are repeated [s].
REPEAT_INTERVAL = 1.0


class NodeBarrier:
    """Finds the nodes that subscribe to topics, and waits until they have responded."""

    def __init__(self, node: Node, executor: Executor, should_stop: Callable[[], bool]) -> None:
        """Start without clients.

        Args:
            node: node that sends the requests.
            executor: executor of this node; it may contain the other nodes, too.
            should_stop: polled while waiting; True ends the wait.
        """
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
        """Return the full names of the nodes that subscribe to a topic.

        Args:
            topic: absolute name, after remapping.
            count: number of subscribers known to the publisher; their node names are waited for.
        """
        deadline = time.monotonic() + DISCOVERY_TIMEOUT
        while True:
            found = self._node.get_subscriptions_info_by_topic(topic)
            names = {full_name(each) for each in found if 'UNKNOWN' not in each.node_name}
            if (len(found) == count and len(names) > 0) or time.monotonic() > deadline or self._should_stop():
                return tuple(sorted(names))
            self._executor.spin_once(timeout_sec=0.01)

    def wait_for_nodes(self, names: Iterable[str], timeout: float) -> None:
        """Wait until the nodes have responded; nodes that have ended or are unresponsive are skipped.

        Args:
            names: fully qualified names of the nodes.
            timeout: longest wait for the responses [s].

        Raises:
            ReplayError: timeout.
        """
        responses = {name: self._request(name) for name in names if self._is_available(name)}
        now = time.monotonic()
        deadline, repeat = now + timeout, now + REPEAT_INTERVAL
        while (pending := self._pending(responses)) and not self._should_stop():
            now = time.monotonic()
            if now > deadline:
                raise ReplayError(
                    f'{", ".join(pending)} has not responded for {timeout:g} s; check whether it hangs'
                )
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
