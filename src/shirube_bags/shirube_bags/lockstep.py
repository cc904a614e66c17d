"""Lock step: the next message goes out when the nodes have worked off the last one.

Nothing is lost then, however slow the nodes and however short their queues, and nothing waits longer than it
must.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rclpy.executors import Executor
from rclpy.node import Node

from shirube_bags.bag_player import CLOCK, BagPlayer
from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_bags.node_questions import NodeQuestions

# A message in one datagram arrives before the question behind it; fragments may be overtaken [bytes].
LARGEST_DATAGRAM = 65_000
# The first message may set off a compilation in the node [s].
ANSWER_TIMEOUT = 180.0
# With other settings of the middleware than play's own, an acknowledgement can take seconds [s].
ACKNOWLEDGE_TIMEOUT = 0.1


class Lockstep:
    """Publishes messages and waits until all that subscribe to them have worked them off."""

    def __init__(
        self,
        player: BagPlayer,
        node: Node,
        executor: Executor,
        timeout: float = ANSWER_TIMEOUT,
        should_stop: Callable[[], bool] = lambda: False,
    ) -> None:
        """Prepare.

        Args:
            player: publishes the messages.
            node: the player's node.
            executor: spins this node; nodes under test may be in it too.
            timeout: how long a node may take for one message [s].
            should_stop: looked at while waiting; True ends it.
        """
        self._player = player
        self._timeout = timeout
        self._questions = NodeQuestions(node, executor, should_stop)
        self._subscribers: dict[str, tuple[int, tuple[str, ...]]] = {}

    @property
    def silent_nodes(self) -> tuple[str, ...]:
        """Subscribing nodes of which nobody can tell when they are ready; known after `wait`."""
        return self._questions.silent_nodes

    def publish(self, message: BagMessage) -> None:
        """Publish a message and wait until it is worked off.

        Raises:
            ReplayError: a node has not answered in time.
        """
        # Nodes look for what has come one subscription after the other: without the question, the message could be
        # found by a look that missed the clock just before.
        self._player.set_clock(message.stamp_ns)
        followers = set(self._subscribers_of(CLOCK)) & set(self._subscribers_of(message.topic))
        self._questions.ask(sorted(followers), self._timeout)
        self._player.publish(message)
        if len(message.raw) > LARGEST_DATAGRAM:
            self._player.wait_until_received([message.topic], ACKNOWLEDGE_TIMEOUT)
        self.wait([message.topic])

    def wait(self, topics: Sequence[str]) -> None:
        """Wait until what was published on the topics is worked off.

        Raises:
            ReplayError: a node has not answered in time.
        """
        names = {name for topic in topics for name in self._subscribers_of(topic)}
        # Nodes look for messages before they look for questions: where both come in between, the question is answered
        # first. The second question is answered after another look for messages.
        for _ in range(2):
            self._questions.ask(sorted(names), self._timeout)

    def _subscribers_of(self, topic: str) -> tuple[str, ...]:
        count = self._player.subscriber_count(topic)
        known_count, names = self._subscribers.get(topic, (0, ()))
        if count != known_count:
            names = self._questions.find_subscribers(self._player.resolved_topic(topic), count)
            self._subscribers[topic] = (count, names)
        return names if count else ()


def replay_in_lockstep(
    bag: BagReader,
    node: Node,
    executor: Executor,
    topics: Sequence[str] = (),
    timeout: float = ANSWER_TIMEOUT,
) -> int:
    """Replay a bag, each message when the last one is worked off: for tests with the nodes in one process.

    Args:
        bag: an open bag.
        node: the player's node.
        executor: spins this node and the nodes under test, which are all there already, in one context.
        topics: topics to replay; all of the bag's if empty.
        timeout: how long a node may take for one message [s].

    Returns:
        How many messages were published.

    Raises:
        ReplayError: a type is not installed, or a node has not answered in time.
        BagError: a topic is not in the bag, or the bag is damaged.
    """
    player = BagPlayer(node, [bag.topics[topic] for topic in bag.select_topics(topics)])
    lockstep = Lockstep(player, node, executor, timeout)
    lockstep.wait(player.topics)
    count = 0
    for message in bag.messages(player.topics):
        lockstep.publish(message)
        count += 1
    return count
