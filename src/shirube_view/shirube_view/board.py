"""The newest message of each channel, decoded only when a page asks."""

import json
import logging
from collections import Counter, deque
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import Any

from shirube_bags.bag_reader import jazzy_types
from shirube_view.channels import Channel, Grid, Kind, jpeg, plain

_LOG = logging.getLogger(__name__)
_KEPT = 200  # number of messages that wait for a page in a channel of which every message is shown


@dataclass
class Seen:
    """What one page has: version of each value, and its grids.

    Attributes:
        version, picture_version: numbers of the newest value and picture that were sent.
        grids: grids that were sent, by channel.
        pictures: channels of pictures that the page looks at.
    """

    version: int = 0
    picture_version: int = 0
    grids: dict[str, Grid] = field(default_factory=dict)
    pictures: Collection[str] = ()


class Board:
    """Newest messages, and their number by channel; `put` may be called from another thread than the rest."""

    def __init__(self) -> None:
        """Start empty."""
        self.counts: Counter[str] = Counter()
        self._waiting: dict[str, tuple[Channel, Any]] = {}
        self._every: deque[tuple[Channel, bytes]] = deque(maxlen=_KEPT)
        self._version = 0
        self._texts: dict[str, tuple[int, str]] = {}
        self._grids: dict[str, tuple[int, Grid]] = {}
        self._pictures: dict[str, tuple[int, Channel, bytes]] = {}

    def put(self, channel: Channel, raw: bytes) -> None:
        """Store a serialized message."""
        self.counts[channel.name] += 1
        if channel.kind is Kind.EVERY:
            self._every.append((channel, raw))
        else:
            self._waiting[channel.name] = channel, raw

    def update(self) -> None:
        """Decode what arrived."""
        arrived: list[tuple[Channel, bytes]] = []
        while self._every:
            arrived.append(self._every.popleft())
        while self._waiting:
            arrived.append(self._waiting.popitem()[1])
        for channel, raw in arrived:
            self._version += 1
            if channel.kind is Kind.PICTURE:
                self._pictures[channel.name] = self._version, channel, raw
                continue
            try:
                self._decode(channel, jazzy_types().deserialize_cdr(raw, channel.type))
            except Exception:  # noqa: BLE001 damaged bytes raise any error of the parser
                _LOG.warning('%s: a message cannot be read and is not shown', channel.topic)

    def _decode(self, channel: Channel, message: Any) -> None:
        if channel.kind is Kind.GRID:
            grid = Grid.from_message(message)
            if grid is not None:
                self._grids[channel.name] = self._version, grid
        elif channel.name == 'diagnostics':
            for status in message.status:
                self._texts[f'diagnostics/{status.name}'] = self._version, json.dumps(plain(status))
        else:
            self._texts[channel.name] = self._version, json.dumps(plain(message))

    def news(self, seen: Seen) -> str:
        """Return what a page has not yet as the members of a JSON object, empty if there is nothing."""
        members = [
            f'{json.dumps(name)}:{text}' for name, (version, text) in self._texts.items() if version > seen.version
        ]
        for name, (version, grid) in self._grids.items():
            if version > seen.version:
                members.append(f'{json.dumps(name)}:{json.dumps(grid.as_json(seen.grids.get(name)))}')
                seen.grids[name] = grid
        return ','.join(members)

    def pictures(self, seen: Seen) -> Iterator[tuple[str, bytes]]:
        """Yield new pictures that a page looks at, with the name of the channel."""
        for name, (version, channel, raw) in list(self._pictures.items()):
            if version > seen.picture_version and name in seen.pictures:
                try:
                    yield name, jpeg(jazzy_types().deserialize_cdr(raw, channel.type), channel.topic)
                except Exception as fault:  # noqa: BLE001 as above
                    _LOG.warning('%s: a picture cannot be shown: %s', channel.topic, fault)

    @property
    def version(self) -> int:
        """Number of the newest value."""
        return self._version
