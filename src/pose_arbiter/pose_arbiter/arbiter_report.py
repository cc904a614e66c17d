"""Diagnostics of the node: which sources are used or rejected, and why; logs important changes."""

from __future__ import annotations

import math
from collections.abc import Callable

from rclpy.node import Node

from pose_arbiter.arbiter_input import ODOMETRY
from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.estimate import Estimate
from pose_arbiter.core.judge import Belief
from pose_arbiter.core.source_record import SourceRecord
from pose_arbiter.core.source_settings import SourceSettings
from pose_arbiter.core.standing import Standing
from pose_arbiter.core.verdict import Verdict
from shirube_ros.diagnostics import Level, Status

_LEVELS = {
    Standing.WAITING: Level.WARN,
    Standing.FOLLOWED: Level.OK,
    Standing.ODOMETRY_ONLY: Level.WARN,
    Standing.LOST: Level.ERROR,
}
_GOOD = (Verdict.USED, Verdict.RESET)
_ODOMETRY_LATE = 0.5  # [s]
_LOOKED_FOR = 5  # number of reports after which topics without publisher are logged


class ArbiterReport:
    """Builds the diagnostics status once a second, and logs resets and a lost pose at once."""

    def __init__(
        self, node: Node, arbiter: Arbiter, sources: dict[str, SourceSettings], now: Callable[[], int]
    ) -> None:
        """Start without a state.

        Args:
            node: node that logs.
            arbiter: arbiter to report.
            sources: settings of the sources, by name.
            now: returns the current time [ns].
        """
        self._node, self._arbiter, self._sources, self._now = node, arbiter, sources, now
        self._standing, self._resets = Standing.WAITING, 0
        self._reports = 0
        self._belief: Belief | None = None
        self._estimate: Estimate | None = None

    def look(self, belief: Belief, estimate: Estimate | None, standing: Standing) -> None:
        """Store the current state; log a reset, and when the pose is lost or found again."""
        if belief.resets > self._resets and estimate is not None:
            place = f'x {estimate.x:.2f} m, y {estimate.y:.2f} m, yaw {math.degrees(estimate.yaw):.0f} deg'
            self._node.get_logger().info(f'pose reset to {place}')
        if standing is not self._standing and Standing.LOST in (standing, self._standing):
            if standing is Standing.LOST:
                self._node.get_logger().error(f'LOST: {self._sigmas(estimate)}')
            else:
                self._node.get_logger().info(standing.value)
        self._standing, self._resets = standing, belief.resets
        self._belief, self._estimate = belief, estimate

    def status(self) -> Status:
        """Return the status for the diagnostics."""
        self._reports += 1
        now = self._now()
        self._tell_silent_topics()
        values = {'state': self._standing.value, 'resets': str(self._resets)}
        if self._estimate is not None:
            values['sigma'] = self._sigmas(self._estimate)
        words, is_well = [], True
        for number, (name, source) in enumerate(self._sources.items()):
            record = SourceRecord() if self._belief is None else self._belief.records[number]
            word, is_good = _word(record, source, now)
            values[name] = word
            is_well = is_well and is_good
            words.append(f'{name} {word}')
        words.append(self._odometry_word(now))
        for (number, verdict), count in sorted(self._arbiter.counts().items(), key=lambda item: str(item[0])):
            name = 'initialpose' if number < 0 else list(self._sources)[number]
            values[f'{name}: {verdict.value}'] = str(count)
        level = _LEVELS[self._standing]
        if level is Level.OK and not is_well:
            level = Level.WARN
        return Status(level, f'{self._standing.value}: {", ".join(words)}', values)

    def _odometry_word(self, now: int) -> str:
        latest = self._arbiter.latest_odometry
        if latest is None:
            return 'no odometry'
        late = (now - latest) * 1e-9
        return f'no odometry for {late:.1f} s' if late > _ODOMETRY_LATE else 'odometry used'

    def _sigmas(self, estimate: Estimate | None) -> str:
        if estimate is None:
            return 'unknown'
        xx, _, _, yy, _, tt = estimate.covariance
        return f'{math.sqrt(max(xx, yy)):.3f} m, {math.degrees(math.sqrt(tt)):.2f} deg'

    def _tell_silent_topics(self) -> None:
        """Log once which topics have no publisher."""
        if self._reports != _LOOKED_FOR:
            return
        topics = {name: source.topic for name, source in self._sources.items()} | {ODOMETRY: ODOMETRY}
        for name, topic in topics.items():
            if self._node.count_publishers(topic) == 0:
                resolved = self._node.resolve_topic_name(topic)
                self._node.get_logger().warning(f'{resolved} ({name}) has no publisher; check the topic name')


def _word(record: SourceRecord, source: SourceSettings, now: int) -> tuple[str, bool]:
    """Return the status text of a source, and whether it is no reason for a warning."""
    if record.latest is None or record.verdict is None:
        return 'no message', True
    age = (now - record.latest.mark.stamp) * 1e-9
    if age > source.timeout:
        return f'no message for {age:.1f} s', True
    if record.verdict in _GOOD:
        return 'used', True
    if record.verdict is Verdict.WAITS:
        return record.verdict.value, True
    return f'rejected ({record.verdict.value})', False
