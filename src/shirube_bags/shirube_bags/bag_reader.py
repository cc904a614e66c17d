"""Reader of rosbag2 bags, mcap or sqlite3, on top of the ``rosbags`` library."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from rosbags.interfaces import Connection, ConnectionExtRosbag2, MessageDefinitionFormat, Qos
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from shirube_bags.errors import BagError


@lru_cache(maxsize=1)
def jazzy_types() -> Typestore:
    """Return the common interfaces of ROS 2 Jazzy as dataclasses, without a ROS installation.

    ``jazzy_types().types['geometry_msgs/msg/PoseStamped']``; the store is shared: do not register types in it.
    """
    return get_typestore(Stores.ROS2_JAZZY)


DAMAGED = 'it is truncated or corrupted: record it again, or repair it with "mcap recover"'


# rosbags says so of a version, storage, compression or serialization that it cannot read.
FOREIGN_WORDS = 'not supported'
FOREIGN = 'convert it with "ros2 bag convert" to a mcap bag of CDR messages, compressed by zstd or not at all'


@dataclass(frozen=True)
class BagTopic:
    """One topic: absolute name, type such as ``sensor_msgs/msg/Image``, message count, QoS of the publishers."""

    name: str
    msgtype: str
    message_count: int
    qos: tuple[Qos, ...]


@dataclass(frozen=True)
class BagMessage:
    """One serialized message (CDR with its header of four bytes) of a topic, with its time of reception [ns]."""

    topic: str
    msgtype: str
    stamp_ns: int
    raw: bytes


class BagReader:
    """Reads one bag: a folder with ``metadata.yaml``, or a single ``.mcap`` or ``.db3`` file.

        with BagReader('bags/floor') as bag:
            for message in bag.messages(['/image_raw']):
                image = bag.decode(message)

    When open, it has the topics by name, the first and the last stamp [ns] and the number of messages.
    """

    def __init__(self, path: Path | str) -> None:
        """Set the path of a bag, which is opened by ``with``."""
        self.path = Path(path)
        self.topics: dict[str, BagTopic] = {}
        self.start_ns = self.end_ns = self.message_count = 0
        self._typestore = jazzy_types()
        self._reader: Reader | None = None

    def __enter__(self) -> Self:
        """Open the bag; raise a BagError if it is missing, empty, truncated, or not a rosbag2."""
        check_is_bag(self.path)
        # A corrupted file raises any error of the parsers (struct, yaml, sqlite, zstd, types).
        try:
            self._reader = Reader(self.path)
            self._reader.open()
            connections = list(self._reader.connections)
            unify_connections(self._reader, connections)
            self._typestore = typestore_for(connections)
        except Exception as fault:
            raise self._make_error(fault) from fault
        self.topics = collect_topics(self.path, connections)
        self.message_count = self._reader.message_count
        if self.message_count == 0:
            self._close()
            raise BagError(f'{self.path}: has no messages; record it again while the topics are published')
        # The end time of rosbags is one past the last message.
        self.start_ns, self.end_ns = self._reader.start_time, self._reader.end_time - 1
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Close the bag."""
        self._close()

    def messages(self, topics: Iterable[str] = ()) -> Iterator[BagMessage]:
        """Yield topics' messages, all if empty, by stamp; raise a BagError for a missing topic or a corrupted bag."""
        wanted = self.select_topics(topics)
        count = 0
        for message in self._read(wanted, None, None):
            count += 1
            yield message
        expected = sum(self.topics[topic].message_count for topic in wanted)
        if count != expected:
            raise BagError(f'{self.path}: has {count} of the {expected} messages in its index; {DAMAGED}')

    def messages_between(self, topics: Iterable[str], begin_ns: int, end_ns: int) -> Iterator[BagMessage]:
        """Yield the messages received from ``begin_ns`` to ``end_ns`` inclusive; topics and errors as `messages`."""
        yield from self._read(self.select_topics(topics), begin_ns, end_ns + 1)

    def _read(self, topics: tuple[str, ...], start_ns: int | None, stop_ns: int | None) -> Iterator[BagMessage]:
        if self._reader is None:
            raise BagError(f'{self.path}: not open; read inside "with BagReader(...) as bag:"')
        connections = [connection for connection in self._reader.connections if connection.topic in topics]
        if not connections:
            return
        try:
            for connection, stamp_ns, raw in self._reader.messages(connections, start_ns, stop_ns):
                yield BagMessage(connection.topic, connection.msgtype, stamp_ns, bytes(raw))
        except Exception as fault:
            raise self._make_error(fault) from fault

    def select_topics(self, topics: Iterable[str]) -> tuple[str, ...]:
        """Return the given topics, all if none is given; raise a BagError for a topic that is not in the bag."""
        wanted = tuple(dict.fromkeys(topics)) or tuple(self.topics)
        for topic in wanted:
            if topic not in self.topics:
                raise BagError(f'{self.path}: has no topic {topic}; it has {", ".join(sorted(self.topics))}')
        return wanted

    def decode(self, message: BagMessage) -> Any:
        """Return a message as a dataclass; raise a BagError if its bytes are invalid."""
        try:
            return self._typestore.deserialize_cdr(message.raw, message.msgtype)
        except Exception as fault:
            if message.msgtype not in self._typestore.fielddefs:
                raise BagError(
                    f'{self.path}: the type {message.msgtype} of {message.topic} is not known and the bag does not '
                    'define it; record it again with "ros2 bag record" of ROS 2 Jazzy'
                ) from fault
            raise BagError(
                f'{self.path}: message on {message.topic} at {message.stamp_ns} ns is not a valid '
                f'{message.msgtype} ({fault}); {DAMAGED}'
            ) from fault

    def _close(self) -> None:
        if self._reader is not None and self._reader.is_open:
            self._reader.close()
        self._reader = None

    def _make_error(self, fault: Exception) -> BagError:
        self._close()
        reason = ' '.join(str(fault).split()).rstrip('.') or type(fault).__name__
        return BagError(f'{self.path}: cannot be read ({reason}); {FOREIGN if FOREIGN_WORDS in reason else DAMAGED}')


def check_is_bag(path: Path) -> None:
    """Raise a BagError with the remedy unless the path is a bag, by file names only."""
    if not path.exists():
        raise BagError(f'{path}: does not exist; give the folder of a rosbag2 or its .mcap file')
    if path.is_dir():
        if not (path / 'metadata.yaml').exists():
            raise BagError(
                f'{path}: is a folder without metadata.yaml, so not a complete bag; give the .mcap file in it, '
                'or run "ros2 bag reindex"'
            )
        return
    if path.suffix == '.bag':
        raise BagError(f'{path}: is a ROS 1 bag; convert it with "rosbags-convert"')
    if path.suffix not in {'.mcap', '.db3'}:
        raise BagError(f'{path}: is not a rosbag2; give the folder with metadata.yaml, or a .mcap or .db3 file')
    if path.stat().st_size == 0:
        raise BagError(f'{path}: is empty; record it again')


def collect_topics(path: Path, connections: Iterable[Connection]) -> dict[str, BagTopic]:
    """Return the topics of a bag by name, several publishers merged; raise a BagError for a topic of two types."""
    topics: dict[str, BagTopic] = {}
    for connection in connections:
        qos = offered_profiles(connection)
        topic = BagTopic(connection.topic, connection.msgtype, connection.msgcount, qos)
        existing = topics.get(topic.name)
        if existing is not None:
            if existing.msgtype != topic.msgtype:
                raise BagError(
                    f'{path}: topic {topic.name} has both {existing.msgtype} and {topic.msgtype}; '
                    'record one type per topic'
                )
            topic = BagTopic(
                topic.name, topic.msgtype, existing.message_count + topic.message_count, existing.qos + qos
            )
        topics[topic.name] = topic
    return topics


def offered_profiles(connection: Connection) -> tuple[Qos, ...]:
    """Return the QoS profiles that the publishers of a topic offered."""
    if isinstance(connection.ext, ConnectionExtRosbag2):
        return tuple(connection.ext.offered_qos_profiles)
    return ()


def unify_connections(reader: Reader, connections: Iterable[Connection]) -> None:
    """Give the topics of each file the QoS and the hash of ``metadata.yaml``.

    rosbags finds a topic's messages by both, but other recorders wrote them differently into the two places.
    """
    known = {(each.topic, each.msgtype): each for each in connections}
    for storage in getattr(reader.storage, 'storages', ()):
        for index, each in enumerate(storage.connections):
            if (named := known.get((each.topic, each.msgtype))) is not None:
                storage.connections[index] = each._replace(ext=named.ext, digest=named.digest)


def typestore_for(connections: Iterable[Connection]) -> Typestore:
    """Return the types of ROS 2 Jazzy and those that only the bag defines, as far as they can be parsed.

    Types of services and actions are not defined in a form that rosbags knows: they are played, not decoded.
    """
    unknown = [each for each in connections if each.msgtype not in jazzy_types().fielddefs]
    if not unknown:
        return jazzy_types()
    typestore = get_typestore(Stores.ROS2_JAZZY)
    for connection in unknown:
        kind, text = connection.msgdef
        try:
            if kind is MessageDefinitionFormat.MSG:
                found = get_types_from_msg(text, connection.msgtype)
            elif kind is MessageDefinitionFormat.IDL:
                found = get_types_from_idl(text)
            else:
                continue
        except TypesysError:
            continue
        typestore.register({name: fields for name, fields in found.items() if name not in typestore.fielddefs})
    return typestore
