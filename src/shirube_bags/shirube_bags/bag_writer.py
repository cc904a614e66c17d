"""Writer of rosbag2 bags: mcap with compressed chunks, created atomically."""

import shutil
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Self

from rosbags.interfaces import Connection, Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer, WriterError

from shirube_bags.bag_reader import jazzy_types
from shirube_bags.errors import BagError

# Infinite duration, as ROS 2 writes it.
INFINITE = QosTime(9223372036, 854775807)

LATCHED_TYPES = frozenset({'nav_msgs/msg/OccupancyGrid'})
LATCHED_TOPICS = frozenset({'/tf_static', '/robot_description'})


def reliable_qos(depth: int = 10, latched: bool = False) -> Qos:
    """Return a reliable profile, for any subscriber, that keeps ``depth`` messages, for late subscribers if latched."""
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=depth,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=INFINITE,
        lifespan=INFINITE,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=INFINITE,
        avoid_ros_namespace_conventions=False,
    )


def default_qos(topic: str, msgtype: str) -> Qos:
    """Return the default profile: latched for maps and static transforms, which are published once."""
    latched = topic in LATCHED_TOPICS or msgtype in LATCHED_TYPES
    return reliable_qos(depth=1 if latched else 10, latched=latched)


class BagWriter:
    """Writes one bag, a folder with ``metadata.yaml`` and an mcap file.

    The bag is written to a temporary folder and renamed when it is complete; if the ``with`` block raises, it is
    removed. ``ros2 bag`` reads and plays the result.

        with BagWriter('bags/floor') as bag:
            bag.write('/odom', 'nav_msgs/msg/Odometry', odometry, stamp_ns)
    """

    def __init__(self, path: Path | str) -> None:
        """Prepare a bag in a folder to create; raise a BagError if it exists already."""
        self.path = Path(path)
        if self.path.exists():
            raise BagError(f'{self.path}: exists already; remove it or choose another name for the bag')
        self.message_count = 0
        self._connections: dict[str, Connection] = {}
        self._folder: Path | None = None
        self._writer: Writer | None = None

    def __enter__(self) -> Self:
        """Open the bag for writing; raise a BagError if the folder is not writable."""
        parent = self.path.absolute().parent
        try:
            parent.mkdir(parents=True, exist_ok=True)
            self._folder = Path(tempfile.mkdtemp(prefix=f'{self.path.name}.partial-', dir=parent))
            # The files in a bag are named after the bag, so it is written under its own name, one level deeper.
            self._writer = Writer(self._folder / self.path.name, version=9, storage_plugin=StoragePlugin.MCAP)
            self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            self._writer.open()
        except OSError as fault:
            raise BagError(f'{self.path}: cannot be created ({fault.strerror}); choose a writable place') from fault
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Complete the bag and rename it to its path, or remove it if the block raised."""
        if self._folder is None or self._writer is None:
            return
        try:
            if kind is None:
                self._writer.close()
                (self._folder / self.path.name).rename(self.path)
            else:
                self._writer.abort()
        except OSError as error:
            raise BagError(
                f'{self.path}: cannot be completed ({error.strerror}); free disk space or choose another folder'
            ) from error
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)

    def declare(self, topic: str, msgtype: str, qos: Qos | None = None) -> None:
        """Add a topic with a QoS profile instead of `default_qos`; raise a BagError for an unknown or other type."""
        known = self._connections.get(topic)
        if known is not None:
            if known.msgtype != msgtype:
                raise BagError(f'{self.path}: topic {topic} has type {known.msgtype}, so {msgtype} needs another topic')
            return
        if msgtype not in jazzy_types().fielddefs:
            raise BagError(
                f'{self.path}: topic {topic} has the unknown type {msgtype!r}; '
                "use one of ROS 2 Jazzy's common interfaces, such as 'sensor_msgs/msg/Image'"
            )
        profile = default_qos(topic, msgtype) if qos is None else qos
        self._connections[topic] = self._open_writer().add_connection(
            topic, msgtype, typestore=jazzy_types(), offered_qos_profiles=[profile]
        )

    def write(self, topic: str, msgtype: str, message: object, stamp_ns: int) -> None:
        """Write a dataclass of `jazzy_types` (an rclpy message: `write_raw`); raise a BagError if it is invalid."""
        self.declare(topic, msgtype)
        try:
            raw = jazzy_types().serialize_cdr(message, msgtype)
        # The serializer is generated code: a wrong field can raise any error.
        except Exception as fault:
            raise BagError(
                f'{self.path}: message on {topic} is not a valid {msgtype} ({fault}); check its fields'
            ) from fault
        self.write_raw(topic, msgtype, raw, stamp_ns)

    def write_raw(self, topic: str, msgtype: str, raw: bytes | memoryview, stamp_ns: int) -> None:
        """Write a message as CDR with its header, received at a stamp >= 0 [ns]; raise a BagError as `declare`."""
        self.declare(topic, msgtype)
        if stamp_ns < 0:
            raise BagError(f'{self.path}: stamp {stamp_ns} ns on {topic} is negative; give nanoseconds >= 0')
        try:
            self._open_writer().write(self._connections[topic], stamp_ns, raw)
        except (OSError, WriterError) as fault:
            raise BagError(
                f'{self.path}: cannot be written ({fault}); free disk space or choose another folder'
            ) from fault
        self.message_count += 1

    def _open_writer(self) -> Writer:
        if self._writer is None:
            raise BagError(f'{self.path}: not open; write inside "with BagWriter(...) as bag:"')
        return self._writer
