"""Questions to nodes: whoever has answered two has worked off the messages that came before the first.

Every node answers questions about its parameters, from the same executor as its messages. An executor looks whether
messages have come, then whether questions have, and works off the messages that it has found before the questions. A
message and a question that come between the two looks are found the wrong way round; but before a second question is
found there was another look for messages. So a node is asked for none of its parameters, twice. That holds for nodes
with the usual executors and callback groups; a node that hands its messages to threads of its own answers too early.
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

# A node and its services are found within milliseconds of its subscriptions, now and then within seconds [s].
DISCOVERY_TIMEOUT = 3.0
# An answer given while its asker is being discovered can get lost [s].
REPEAT_INTERVAL = 1.0


class NodeQuestions:
    """Finds the nodes that subscribe to topics, asks them, and waits for their answers."""

    def __init__(self, node: Node, executor: Executor, should_stop: Callable[[], bool]) -> None:
        """Prepare.

        Args:
            node: asks.
            executor: spins this node; the nodes that are asked may be in it too.
            should_stop: looked at while waiting; True ends it.
        """
        self._node = node
        self._executor = executor
        self._should_stop = should_stop
        self._clients: dict[str, Client] = {}
        self._silent: set[str] = set()

    @property
    def silent_nodes(self) -> tuple[str, ...]:
        """The nodes that have no parameter service, so that nobody can tell when they are ready."""
        return tuple(sorted(self._silent))

    def find_subscribers(self, topic: str, count: int) -> tuple[str, ...]:
        """Return the full names of the nodes that subscribe to a topic.

        Args:
            topic: absolute name, after remapping.
            count: subscribers known to the publisher; the names of their nodes are waited for.
        """
        deadline = time.monotonic() + DISCOVERY_TIMEOUT
        while True:
            found = self._node.get_subscriptions_info_by_topic(topic)
            names = {full_name(each) for each in found if 'UNKNOWN' not in each.node_name}
            if (len(found) == count and len(names) > 0) or time.monotonic() > deadline or self._should_stop():
                return tuple(sorted(names))
            self._executor.spin_once(timeout_sec=0.01)

    def ask(self, names: Iterable[str], timeout: float) -> None:
        """Wait until the nodes have answered; those that have ended or never answer are left out.

        Args:
            names: full names of the nodes.
            timeout: how long the answers may take [s].

        Raises:
            ReplayError: the time is over.
        """
        answers = {name: self._question(name) for name in names if self._can_be_asked(name)}
        now = time.monotonic()
        deadline, repeat = now + timeout, now + REPEAT_INTERVAL
        while (waiting := self._unanswered(answers)) and not self._should_stop():
            now = time.monotonic()
            if now > deadline:
                raise ReplayError(
                    f'{", ".join(waiting)} has not answered for {timeout:g} s; look whether it hangs'
                )
            if now > repeat:
                answers.update({name: self._question(name) for name in waiting})
                repeat = now + REPEAT_INTERVAL
            self._executor.spin_once(timeout_sec=0.1)

    def _question(self, name: str) -> Future:
        return self._clients[name].call_async(GetParameters.Request())

    def _unanswered(self, answers: dict[str, Future]) -> list[str]:
        return [
            name
            for name, answer in answers.items()
            if not answer.done() and self._clients[name].service_is_ready()
        ]

    def _can_be_asked(self, name: str) -> bool:
        if name in self._silent:
            return False
        if name not in self._clients:
            self._clients[name] = self._node.create_client(GetParameters, f'{name}/get_parameters')
            deadline = time.monotonic() + DISCOVERY_TIMEOUT
            while not self._clients[name].service_is_ready() and not self._should_stop():
                if time.monotonic() > deadline:
                    self._silent.add(name)
                    break
                self._executor.spin_once(timeout_sec=0.01)
        return bool(self._clients[name].service_is_ready())


def full_name(endpoint: TopicEndpointInfo) -> str:
    """Return the namespace and name of the node that an endpoint belongs to."""
    return f'{endpoint.node_namespace.rstrip("/")}/{endpoint.node_name}'
