"""Which velocity commands are obeyed: priorities of topics, and senders that contradict each other on one topic."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from motor_bridge.core.diff_drive_kinematics import Velocity
from motor_bridge.core.motor_bridge_error import MotorBridgeError

MIXED_TIME = 1.0
"""Commands are mixed until none was for this time; a sender that is silent for so long sends no more [s]."""
_NUMBER_STEP_MAX = 20  # so many messages of a publisher may be lost in a row
_VELOCITY_STEP_MAX = Velocity(0.1, 0.2)  # between two messages of one publisher
_SENDERS_MAX = 8


@dataclass(frozen=True)
class CommandTopic:
    """A topic of commands: name, priority, and time after its last message at which it has none any more [s]."""

    name: str
    priority: float = 0.0
    timeout: float = math.inf


def parse_mux_topics(text: str) -> list[CommandTopic]:
    """Parse topics such as ``joy_vel 10 0.5, cmd_vel 1 0.5``.

    Raises:
        MotorBridgeError: another format, a duplicate topic or priority.
    """
    topics = []
    for entry in filter(None, map(str.strip, text.split(','))):
        try:
            name, priority, timeout = entry.split()
            topics.append(CommandTopic(name, float(priority), float(timeout)))
        except ValueError:
            topics.append(CommandTopic(entry, math.nan))
        topic = topics[-1]
        is_name = re.fullmatch(r'(/|~/)?[A-Za-z_]\w*(/[A-Za-z_]\w*)*', topic.name, re.ASCII)
        if not (is_name and math.isfinite(topic.priority) and 0.0 < topic.timeout < math.inf):
            raise MotorBridgeError(
                f'mux_topics has {entry!r}; write topic, priority and timeout, such as joy_vel 10 0.5, cmd_vel 1 0.5'
            )
    if any(len({getattr(t, key) for t in topics}) < len(topics) for key in ('name', 'priority')):
        raise MotorBridgeError('mux_topics has a topic or a priority twice; give each topic its own')
    return topics


class CommandMux:
    """Chooses the topic with the highest priority that has not timed out."""

    def __init__(self, topics: list[CommandTopic]) -> None:
        """Start without messages."""
        self._topics = topics
        self._times = {topic.name: -math.inf for topic in topics}

    def take(self, name: str, now: float) -> bool:
        """Take a message of a topic at a time [s]; return whether it is obeyed."""
        self._times[name] = now
        alive = [each for each in self._topics if 0.0 <= now - self._times[each.name] <= each.timeout]
        return max(alive, key=lambda each: each.priority).name == name


@dataclass(frozen=True)
class _Command:
    """The last command of a sender; its number is None if the middleware counts none."""

    number: int | None
    velocity: Velocity
    time: float

    def gap(self, after: _Command) -> float:
        """Return how far another command is from this one; infinite if it cannot be the next one of its sender."""
        if self.number is not None and after.number is not None:
            step = after.number - self.number
            return step if 0 < step <= _NUMBER_STEP_MAX else math.inf
        return max(
            _gap(after.velocity.forward - self.velocity.forward, _VELOCITY_STEP_MAX.forward),
            _gap(after.velocity.turn_rate - self.velocity.turn_rate, _VELOCITY_STEP_MAX.turn_rate),
        )


def _gap(difference: float, limit: float) -> float:
    return abs(difference) / limit if abs(difference) <= limit else math.inf


class SenderMonitor:
    """Notices when the commands of several senders are interleaved, though messages do not name their sender.

    A publisher numbers its messages. So a command continues the row of one sender, or begins another row. Commands are
    mixed if one continues a row that is not the latest one: A, B, A. One publisher after another is not mixed. Without
    numbers a row is one of similar velocities.
    """

    def __init__(self) -> None:
        """Start without commands."""
        self._rows: list[_Command] = []  # the last command of each sender, the latest one last
        self._mixed_time = -math.inf

    def take(self, number: int | None, velocity: Velocity, now: float) -> None:
        """Take a command that was received at a time [s]."""
        command = _Command(number, velocity, now)
        rows = [row for row in self._rows if 0.0 <= now - row.time <= MIXED_TIME]
        continued = min(reversed(rows), key=lambda row: row.gap(command), default=None)
        if continued is not None and math.isinf(continued.gap(command)):
            continued = None
        if continued is not None and continued is not rows[-1]:
            self._mixed_time = now
        self._rows = [*(row for row in rows if row is not continued), command][-_SENDERS_MAX:]

    def is_mixed(self, now: float) -> bool:
        """Return whether commands were mixed shortly before a time [s]."""
        return 0.0 <= now - self._mixed_time <= MIXED_TIME
