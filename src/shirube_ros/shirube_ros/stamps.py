"""Validates the stamps of messages, and groups messages of several topics by them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from std_msgs.msg import Header

from shirube_ros.errors import MessageError

_JUMP_MIN = 1.0  # a smaller step back is not a jump of the clock [s]
_STEP_MAX = 5.0  # largest difference between stamps that are consistent [s]
_RUN_MIN = 2  # old stamps of a topic that support those of another one
_LONE_RUN_MIN = 5  # old stamps of one topic that are enough while all others are silent
_QUEUE_MAX = 10  # items of a topic that wait for their group
_CLOCK_OFFSET_MAX = 1.0  # tolerated clock difference between hosts [s]

Item = TypeVar('Item')


class StampError(MessageError):
    """A message is older than its predecessor, or its stamp is zero or in the future."""


@dataclass
class _Topic:
    """Latest accepted stamp [s], and the run of consistent old stamps since then, of which the latest is kept."""

    latest: float
    run_length: int = 0
    run_stamp: float = 0.0


class StampValidator:
    """Checks that stamps do not decrease within a topic, and finds jumps of the clock.

    One old stamp is rejected. The clock jumped back if the node's clock did, if several topics have runs of consistent
    old stamps, or if the only topic that is received has one.
    """

    def __init__(self, on_jump_back: Callable[[], None], now: Callable[[], float] | None = None) -> None:
        """Start without stamps.

        Args:
            on_jump_back: called when the clock jumped back.
            now: returns the current time [s], 0 before simulated time has started. If given, stamps that are zero or
                in the future are rejected, and a clock that goes back is a jump.
        """
        self._on_jump_back, self._now = on_jump_back, now
        self._topics: dict[str, _Topic] = {}
        self._latest_now = 0.0

    def check(self, header: Header, topic: str) -> float:
        """Return the stamp of a message of a topic [s]; each topic is checked separately.

        Raises:
            StampError: the message is out of order, or its stamp is zero or in the future.
        """
        stamp = float(header.stamp.sec + header.stamp.nanosec * 1e-9)
        self._check_clock(stamp, topic)
        state = self._topics.setdefault(topic, _Topic(stamp))
        if stamp < state.latest and not self._is_new_time(stamp, state):
            raise StampError(f'{topic} came out of order or late; check the network and the stamps of its publisher')
        # A topic in the known time contradicts a jump.
        for each in self._topics.values():
            each.run_length = 0
        self._topics[topic] = _Topic(stamp)
        return stamp

    def _is_new_time(self, stamp: float, state: _Topic) -> bool:
        """Add an old stamp to the run of its topic; return whether the clock jumped back and all topics start again."""
        if state.latest - stamp <= _JUMP_MIN:
            return False
        is_next = state.run_length > 0 and 0.0 < stamp - state.run_stamp <= _STEP_MAX
        state.run_length, state.run_stamp = state.run_length + 1 if is_next else 1, stamp
        if state.run_length < _RUN_MIN:
            return False
        supporters = [
            each
            for each in self._topics.values()
            if each.run_length >= _RUN_MIN and abs(each.run_stamp - stamp) <= _STEP_MAX
        ]
        if len(supporters) == 1 and state.run_length < _LONE_RUN_MIN:
            return False
        self._jump_back()
        return True

    def _jump_back(self) -> None:
        self._topics.clear()
        self._on_jump_back()

    def _check_clock(self, stamp: float, topic: str) -> None:
        now = 0.0 if self._now is None else self._now()
        if now <= 0.0:
            return
        before, self._latest_now = self._latest_now, now
        if now < before - _JUMP_MIN:
            self._jump_back()
        if stamp == 0.0:
            raise StampError(f'{topic} has a stamp of 0; let its publisher set header.stamp')
        if stamp > now + _CLOCK_OFFSET_MAX:
            raise StampError(
                f'{topic} has a stamp in the future; synchronize the clocks, and set use_sim_time of all nodes alike'
            )


class StampSynchronizer(Generic[Item]):
    """Groups one item of each topic with matching stamps, as message_filters' approximate time synchronizer.

    It counts completed groups and items dropped without a match.
    """

    def __init__(self, topics: Sequence[str], tolerance: float) -> None:
        """Start with empty queues for a group of topics whose stamps differ by ``tolerance`` at most [s]."""
        self.completed = self.dropped = 0
        self._topics = tuple(topics)
        self._tolerance = tolerance
        self._queues: dict[str, list[tuple[float, Item]]] = {topic: [] for topic in topics}

    def put(self, topic: str, stamp: float, item: Item) -> tuple[Item, ...] | None:
        """Add an item with its stamp [s]; return its group, in the order of the topics, once it is complete."""
        queue = self._queues[topic]
        queue.append((stamp, item))
        if len(queue) > _QUEUE_MAX:
            queue.pop(0)
            self.dropped += 1
        indices = [self._find_match(other, stamp) for other in self._topics]
        if None in indices:
            return None
        group = []
        for other, index in zip(self._topics, indices, strict=True):
            assert index is not None  # noqa: S101 for the type checker
            group.append(self._queues[other][index][1])
            self.dropped += index
            del self._queues[other][: index + 1]
        self.completed += 1
        return tuple(group)

    @property
    def missing_topics(self) -> tuple[str, ...]:
        """Topics with an empty queue; none if all have items but their stamps differ."""
        return tuple(topic for topic in self._topics if not self._queues[topic])

    def clear(self) -> None:
        """Clear the queues."""
        for queue in self._queues.values():
            queue.clear()

    def _find_match(self, topic: str, stamp: float) -> int | None:
        stamps = [other for other, _ in self._queues[topic]]
        return next((i for i, other in enumerate(stamps) if abs(other - stamp) <= self._tolerance), None)
