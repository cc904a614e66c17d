"""Writing of rosbag2 bags: mcap with compressed chunks, complete or not there at all."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Self

from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer, WriterError

from shirube_bags.bag_qos import default_qos
from shirube_bags.errors import BagError
from shirube_bags.message_types import jazzy_types


class BagWriter:
    """Writes one bag, a folder with ``metadata.yaml`` and an mcap file.

    The bag grows in a folder beside its place and is renamed when it is complete; when the ``with`` block
    raises, nothing is left behind. Real ``ros2 bag`` reads and plays what comes out.

        with BagWriter('bags/floor') as bag:
            bag.write('/odom', 'nav_msgs/msg/Odometry', odometry, stamp_ns)
    """

    def __init__(self, path: Path | str) -> None:
        """Prepare a bag.

        Args:
            path: the folder to make; its parents are made too.

        Raises:
            BagError: something stands there already.
        """
        self.path = Path(path)
        if self.path.exists():
            raise BagError(f'{self.path}: exists already; remove it or choose another name for the bag')
        self.message_count = 0
        self._connections: dict[str, Connection] = {}
        self._folder: Path | None = None
        self._writer: Writer | None = None

    def __enter__(self) -> Self:
        """Open the bag for writing.

        Raises:
            BagError: the place cannot be written to.
        """
        parent = self.path.absolute().parent
        try:
            parent.mkdir(parents=True, exist_ok=True)
            self._folder = Path(tempfile.mkdtemp(prefix=f'{self.path.name}.partial-', dir=parent))
            # The files in a bag carry the bag's own name, so it grows under that name one level deeper.
            self._writer = Writer(self._folder / self.path.name, version=9, storage_plugin=StoragePlugin.MCAP)
            self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            self._writer.open()
        except OSError as fault:
            raise BagError(
                f'{self.path}: cannot be made ({fault.strerror}); choose a writable place'
            ) from fault
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Complete the bag and put it in its place, or leave nothing if the block raised."""
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
                f'{self.path}: cannot be completed ({error.strerror}); make room or choose another place'
            ) from error
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)

    def declare(self, topic: str, msgtype: str, qos: Qos | None = None) -> None:
        """Add a topic with a quality of service of its own; needed only where the default does not fit.

        Args:
            topic: absolute name, as ``/image_raw``.
            msgtype: as ``sensor_msgs/msg/Image``.
            qos: the profile a player shall offer; by default `default_qos`.

        Raises:
            BagError: the type is unknown, or the topic is there with another type.
        """
        known = self._connections.get(topic)
        if known is not None:
            if known.msgtype != msgtype:
                raise BagError(
                    f'{self.path}: topic {topic} holds {known.msgtype}, so {msgtype} needs another topic'
                )
            return
        if msgtype not in jazzy_types().fielddefs:
            raise BagError(
                f'{self.path}: topic {topic} has the unknown type {msgtype!r}; '
                "use one of ROS 2 Jazzy's common interfaces, as 'sensor_msgs/msg/Image'"
            )
        profile = default_qos(topic, msgtype) if qos is None else qos
        self._connections[topic] = self._open_writer().add_connection(
            topic, msgtype, typestore=jazzy_types(), offered_qos_profiles=[profile]
        )

    def write(self, topic: str, msgtype: str, message: object, stamp_ns: int) -> None:
        """Write one message.

        Args:
            topic: absolute name, as ``/image_raw``.
            msgtype: as ``sensor_msgs/msg/Image``.
            message: a dataclass of `jazzy_types`, not a message of rclpy (for these: `write_raw`).
            stamp_ns: when the message was received [ns since the epoch or since the start].

        Raises:
            BagError: the message does not fit its type, or see `declare`.
        """
        self.declare(topic, msgtype)
        try:
            raw = jazzy_types().serialize_cdr(message, msgtype)
        # The serializer is generated code: a wrong field ends in whatever Python raises there.
        except Exception as fault:
            raise BagError(
                f'{self.path}: message on {topic} is no valid {msgtype} ({fault}); check its fields'
            ) from fault
        self.write_raw(topic, msgtype, raw, stamp_ns)

    def write_raw(self, topic: str, msgtype: str, raw: bytes | memoryview, stamp_ns: int) -> None:
        """Write one message that is serialized already (CDR with its four bytes of header).

        Raises:
            BagError: the stamp is negative, the disk is full, or see `declare`.
        """
        self.declare(topic, msgtype)
        if stamp_ns < 0:
            raise BagError(f'{self.path}: stamp {stamp_ns} ns on {topic} is negative; give nanoseconds >= 0')
        try:
            self._open_writer().write(self._connections[topic], stamp_ns, raw)
        except (OSError, WriterError) as fault:
            raise BagError(
                f'{self.path}: cannot be written ({fault}); make room or choose another place'
            ) from fault
        self.message_count += 1

    def _open_writer(self) -> Writer:
        if self._writer is None:
            raise BagError(f'{self.path}: not open; write inside "with BagWriter(...) as bag:"')
        return self._writer
