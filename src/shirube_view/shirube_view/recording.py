"""Plays a bag for one page, with a time line."""

from collections.abc import Iterator
from pathlib import Path

from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_bags.stamps import NANOSECONDS
from shirube_view.board import Board
from shirube_view.channels import CHANNELS, RECORDED_PICTURES, Channel, Kind

_LOOK_BACK = 2 * NANOSECONDS
"""After a jump, messages of this time before are shown; of maps, plans and goals the latest [ns]."""
_STEP_MAX = 1.0  # longest step of the time line between two updates [s]


class Recording:
    """A bag that is played in a `with` statement; times are in seconds since its first message.

    Attributes:
        board: newest messages before the current time.
        time: current time [s].
        length: duration [s].
        speed: speed of the time line, 0 while it is paused.
    """

    def __init__(self, path: Path) -> None:
        """Open a bag; raise a BagError if it is none, or has nothing to show."""
        self._bag = BagReader(path)
        self._bag.__enter__()
        self._channels = _find_channels(self._bag)
        self.length = (self._bag.end_ns - self._bag.start_ns) / NANOSECONDS
        self.time, self.speed = 0.0, 1.0
        self.seek(0.0)

    def close(self) -> None:
        """Close the bag."""
        self._bag.__exit__(None, None, None)

    def seek(self, time: float) -> None:
        """Jump to a time [s]."""
        self.time = min(max(time, 0.0), self.length)
        at = self._bag.start_ns + round(self.time * NANOSECONDS)
        self.board = Board()
        lasting = [t for t, c in self._channels.items() if c.is_latched or c.name == 'goal']
        latest = {each.topic: each for each in self._between(lasting, self._bag.start_ns, at)}
        for each in (*latest.values(), *self._between(list(self._channels), at - _LOOK_BACK, at)):
            self.board.put(self._channels[each.topic], each.raw)
        self._coming = self._between(list(self._channels), at + 1, self._bag.end_ns)
        self._next = next(self._coming, None)

    def advance(self, elapsed: float) -> None:
        """Let time pass [s]."""
        self.time = min(self.time + self.speed * min(elapsed, _STEP_MAX), self.length)
        now = self._bag.start_ns + round(self.time * NANOSECONDS)
        while self._next is not None and self._next.stamp_ns <= now:
            self.board.put(self._channels[self._next.topic], self._next.raw)
            self._next = next(self._coming, None)

    def _between(self, topics: list[str], begin: int, end: int) -> Iterator[BagMessage]:
        return self._bag.messages_between(topics, begin, end) if topics and begin <= end else iter(())


def _find_channels(bag: BagReader) -> dict[str, Channel]:
    """Return the channels of a bag's topics."""
    found = dict[str, Channel]()
    for channel in CHANNELS:
        recorded = RECORDED_PICTURES.get(channel.name, ()) if channel.kind is Kind.PICTURE else ()
        for name in (channel.topic.strip('/'), *recorded):
            topic = next((each for each in bag.topics if each.strip('/') == name), None)
            if topic is not None:
                msgtype = bag.topics[topic].msgtype
                found[topic] = Channel(channel.name, topic, msgtype, channel.kind, channel.is_latched)
                break
    return found
