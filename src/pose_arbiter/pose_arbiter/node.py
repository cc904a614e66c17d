"""The ROS node: fuses the poses of all sources and odometry into one pose."""

from __future__ import annotations

import sys
from typing import Any

from rclpy.node import Node

from pose_arbiter.arbiter_input import ArbiterInput, ClockMonitor
from pose_arbiter.arbiter_output import ArbiterOutput, TickSchedule
from pose_arbiter.arbiter_report import ArbiterReport
from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.kalman_filter import Estimate
from pose_arbiter.core.localization_status import LocalizationStatus, localization_status
from pose_arbiter.core.outlier_rejection import FilterState
from pose_arbiter.core.settings import ArbiterSettings
from pose_arbiter.core.source_state import NEVER
from pose_arbiter.node_settings import NodeSettings
from pose_arbiter.source_parameters import declare_sources
from shirube_core.settings import SettingsError
from shirube_ros.callback_guard import CallbackGuard, create_trigger_service
from shirube_ros.diagnostics import Diagnostics
from shirube_ros.node import run_node
from shirube_ros.parameters import declare_parameters, reject_misspelled_parameters

_OUTPUT = 'output'  # name of the timer callback in the diagnostics


class PoseArbiterNode(Node):
    """Publishes one pose fused from all sources and odometry.

    =========================  ==========================  ===================================================
    subscribed                 type                        use
    =========================  ==========================  ===================================================
    ``<name>.topic``           PoseWithCovarianceStamped   pose of a source; or PoseStamped (``with_covariance``)
    ``odom``                   Odometry                    motion of the robot between poses
    ``initialpose``            PoseWithCovarianceStamped   pose set by an operator
    =========================  ==========================  ===================================================

    =========================  ==========================  ===================================================
    published                  type                        when
    =========================  ==========================  ===================================================
    ``~/pose``                 PoseStamped                 50 Hz (``rate``), while the pose is known
    ``~/odometry``             Odometry                    with each pose: covariance, and the twist of ``odom``
    ``/tf``                    TFMessage                   with each pose, map to odom (needs tf2_ros)
    ``~/initialpose``          PoseWithCovarianceStamped   once when the source ``initialpose_for`` falls silent
    ``/diagnostics``           DiagnosticArray             1 Hz
    =========================  ==========================  ===================================================

    Service (Trigger): ``~/reset`` clears the pose and the states of the sources.
    """

    def __init__(self, **options: Any) -> None:
        """Subscribe to the sources.

        Args:
            options: keyword arguments of ``rclpy.node.Node``.

        Raises:
            SettingsError: a bad parameter, or two parameters that contradict each other.
        """
        super().__init__('pose_arbiter', **options)
        self._settings = declare_parameters(self, NodeSettings)
        self._filter_settings = declare_parameters(self, ArbiterSettings)
        sources = declare_sources(self, self._settings.map_frame)
        reject_misspelled_parameters(self)
        frames = (self._settings.map_frame, self._settings.odom_frame, self._settings.base_frame)
        if len(set(frames)) < len(frames):
            raise SettingsError(
                'two of map_frame, odom_frame and base_frame are the same; give each frame its own name'
            )
        self._sources = tuple(sources.values())
        helped = self._settings.initialpose_for
        if helped and helped not in sources:
            raise SettingsError(
                f'setting initialpose_for is {helped!r}, it must be one of {", ".join(sources)}'
            )
        self._helped = list(sources).index(helped) if helped else None
        self._helped_after: tuple[int, int] | None = None
        self._arbiter = Arbiter(self._sources, self._filter_settings)
        self._clock_monitor = ClockMonitor(self, self._on_clock_jump)
        self._guard = CallbackGuard(self)
        self._schedule = TickSchedule(self._settings.rate)
        self._report = ArbiterReport(self, self._arbiter, sources, self._clock_monitor.now)
        self._output = ArbiterOutput(self, self._settings)
        self._input = ArbiterInput(
            self, self._guard, self._arbiter, sources, self._settings, self._clock_monitor.now
        )
        create_trigger_service(self, self._guard, '~/reset', self._reset)
        publish_due = self._guard.guard(_OUTPUT, self._publish_due)
        self.create_timer(1.0 / self._settings.rate, lambda: publish_due(None))
        self._diagnostics = Diagnostics(self, self._guard.counts, self._report.status)

    def _publish_due(self, _: None) -> None:
        """Publish all due poses."""
        for stamp in self._schedule.due(self._clock_monitor.now()):
            state, estimate = self._arbiter.state_at(stamp), self._arbiter.estimate_at(stamp)
            status = localization_status(state, estimate, self._sources, self._filter_settings)
            self._report.observe(state, estimate, status)
            if status.has_pose and estimate is not None:
                self._output.publish_pose(stamp, estimate, self._input.twist)
                self._publish_transform(stamp)
            if status is LocalizationStatus.TRACKING and estimate is not None:
                self._publish_area(stamp, state, estimate)

    def _publish_transform(self, stamp: int) -> None:
        """Publish map to odom, as computed at the stamp of the latest odometry."""
        latest = self._arbiter.latest_odometry
        estimate = None if latest is None else self._arbiter.estimate_at(min(latest, stamp))
        T_map_odom = None if estimate is None else self._arbiter.T_map_odom(estimate)
        if T_map_odom is not None:
            self._output.publish_transform(stamp, T_map_odom)

    def _publish_area(self, stamp: int, state: FilterState, estimate: Estimate) -> None:
        """Publish the pose for the localizer ``initialpose_for``: once when it falls silent, and after each reset."""
        if self._helped is None:
            return
        source = state.source_states[self._helped]
        latest = NEVER if source.latest is None else source.latest.odometry.stamp
        is_silent = stamp - latest > self._sources[self._helped].timeout * 1e9
        if is_silent and self._helped_after != (state.resets, latest):
            self._helped_after = state.resets, latest
            self._output.publish_area(stamp, estimate)

    def _reset(self) -> str:
        self._arbiter.reset()
        return 'pose reset'

    def _on_clock_jump(self) -> None:
        self.get_logger().warning('clock jumped: pose and source history were reset')
        self._arbiter.reset()
        self._schedule.reset()


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('pose_arbiter', PoseArbiterNode)


if __name__ == '__main__':
    sys.exit(main())
