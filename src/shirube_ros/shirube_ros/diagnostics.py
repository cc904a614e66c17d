"""Publishes the status of a node on /diagnostics, once a second."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from shirube_ros.callback_guard import TopicCount
from shirube_ros.input_watch import InputWatch

_PERIOD = 1.0  # [s]


class Level(Enum):
    """Level of a diagnostic status."""

    OK = DiagnosticStatus.OK
    WARN = DiagnosticStatus.WARN
    ERROR = DiagnosticStatus.ERROR


@dataclass(frozen=True)
class Status:
    """Level, message of one sentence, and values in the order in which they are published."""

    level: Level
    message: str
    values: Mapping[str, str] = field(default_factory=dict)


class Diagnostics:
    """Publishes a node's status with its message counts."""

    def __init__(
        self,
        node: Node,
        counts: Mapping[str, TopicCount],
        current_status: Callable[[], Status],
        inputs: InputWatch | None = None,
    ) -> None:
        """Start publishing the status, asked for once per report, the message counts of the node's guard, by topic,
        and the problems of its inputs.
        """
        self._node = node
        self._counts = counts
        self._inputs = inputs
        self._current_status = current_status
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        # A steady clock: publish also while simulated time is paused.
        node.create_timer(_PERIOD, self.publish, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def publish(self) -> None:
        """Publish the status now."""
        if self._inputs is not None:
            self._inputs.check()
        report = DiagnosticArray(status=[self._report()])
        report.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(report)

    def _report(self) -> DiagnosticStatus:
        status = self._current_status()
        level, message = status.level, status.message
        warnings = self._new_rejections()
        if self._inputs is not None:
            warnings = [*self._inputs.mismatches, *warnings]
            # Without its input, what a node found last is no longer true.
            message = '; '.join(self._inputs.missing) or message
        if warnings or message != status.message:
            level = Level.WARN if level is Level.OK else level
            message = '; '.join([message, *warnings])
        values = [KeyValue(key=key, value=value) for key, value in status.values.items()]
        if self._inputs is not None:
            values += [KeyValue(key='input', value=problem) for problem in self._inputs.problems.values()]
        return DiagnosticStatus(
            level=level.value,
            name=f'{self._node.get_fully_qualified_name().strip("/")}: status',
            message=message,
            values=values + self._count_values(),
        )

    def _new_rejections(self) -> list[str]:
        rejections = []
        for count in self._counts.values():
            if count.latest_rejection is not None:
                rejections.append(count.latest_rejection)
                count.latest_rejection = None
        return rejections

    def _count_values(self) -> list[KeyValue]:
        values = []
        for topic, count in self._counts.items():
            values.append(KeyValue(key=f'{topic} received', value=str(count.received)))
            for reason, number in count.rejected.items():
                values.append(KeyValue(key=f'{topic} rejected', value=f'{number}: {reason}'))
        return values
