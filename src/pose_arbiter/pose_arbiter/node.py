"""The ROS node: fuses the poses of all sources and odometry into one pose."""

import re
import sys
from dataclasses import field, fields, make_dataclass, replace
from keyword import iskeyword
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_topic_name import validate_topic_name

from pose_arbiter.arbiter_input import ArbiterInput, ClockMonitor
from pose_arbiter.arbiter_output import ArbiterOutput, ArbiterReport, TickSchedule
from pose_arbiter.core.arbiter import Arbiter, LocalizationStatus, localization_status
from pose_arbiter.core.kalman_filter import Estimate
from pose_arbiter.core.outlier_rejection import FilterState
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from pose_arbiter.core.source_state import NEVER
from pose_arbiter.node_settings import NodeSettings
from shirube_core.settings import SettingsError
from shirube_ros.callback_guard import create_trigger_service
from shirube_ros.diagnostics import Status
from shirube_ros.managed_node import ManagedNode
from shirube_ros.node import run_node

DEFAULT_SOURCES = ('floor_localizer', 'stereo_landmark', 'vlc_beacon')
"""The localizers of this suite."""
_PARAMETER = 'sources'
_RESERVED_NAMES = (
    'odom',
    'initialpose',
    'output',
    'state',
    'sigma',
    'lifecycle',
    'input',
)  # reserved as keys of the diagnostics


def declare_sources(node: ManagedNode) -> type:
    """Declare the parameters of the sources; return the class of their settings, which has one group a source.

    Raises:
        SettingsError: no names, an invalid or duplicate name, or an invalid value.
    """
    names = _declare_names(node)
    groups = make_dataclass(
        'SourceGroups', [(name, SourceSettings, field(default_factory=SourceSettings)) for name in names], frozen=True
    )
    node.declare(groups)
    return groups


def _declare_names(node: Node) -> list[str]:
    descriptor = ParameterDescriptor(
        description='names of the pose sources; each has the parameters <name>.topic and so on',
        dynamic_typing=True,
        read_only=True,
    )
    value = node.declare_parameter(_PARAMETER, list(DEFAULT_SOURCES), descriptor).value
    if not isinstance(value, (list, tuple)) or not all(isinstance(name, str) for name in value) or not value:
        raise SettingsError(f'setting {_PARAMETER} is {value!r}, it must be a list of names, such as [floor, lamps]')
    names = [str(name) for name in value]
    for name in names:
        if not re.fullmatch(r'[a-z][a-z0-9_]*', name) or iskeyword(name):
            raise SettingsError(
                f'setting {_PARAMETER} holds {name!r}; a name has lower-case letters, digits and underscores '
                'and is not a Python keyword'
            )
        if names.count(name) > 1:
            raise SettingsError(f'setting {_PARAMETER} holds {name} twice; give each source a unique name')
        if node.has_parameter(name):
            raise SettingsError(f'setting {_PARAMETER} holds {name}, which is a parameter; use another name')
        if name in _RESERVED_NAMES:
            raise SettingsError(
                f'setting {_PARAMETER} holds {name}, which is reserved in the diagnostics; use another name'
            )
    return names


def fill_defaults(groups: Any, map_frame: str) -> dict[str, SourceSettings]:
    """Return the settings of the sources by name; topics and frames that are empty have their defaults."""
    return {each.name: _fill(each.name, getattr(groups, each.name), map_frame) for each in fields(groups)}


def _fill(name: str, source: SourceSettings, map_frame: str) -> SourceSettings:
    default_topic = f'{name}/pose_with_covariance' if source.with_covariance else f'{name}/pose'
    return replace(source, topic=source.topic or default_topic, frame=source.frame or map_frame)


def reject_shared_topics(node: Node, sources: dict[str, SourceSettings]) -> None:
    """Raise a SettingsError for an invalid topic, one of two sources, or one of this node."""
    own = {node.resolve_topic_name(topic) for topic in ('~/pose', '~/odometry')}
    owners: dict[str, str] = {}
    for name, source in sources.items():
        topic = _resolve_topic(node, name, source.topic)
        if topic in own:
            raise SettingsError(
                f'setting {name}.topic is {topic}, an output of this node; use the topic of a localizer'
            )
        if topic in owners:
            raise SettingsError(
                f'sources {owners[topic]} and {name} have the same topic {topic}; give each its own topic'
            )
        owners[topic] = name


def _resolve_topic(node: Node, name: str, topic: str) -> str:
    try:
        validate_topic_name(topic)
    except InvalidTopicNameException as error:
        raise SettingsError(f'setting {name}.topic is {topic!r}, which is not a valid topic name') from error
    return str(node.resolve_topic_name(topic))


_OUTPUT = 'output'  # name of the timer callback in the diagnostics


class PoseArbiterNode(ManagedNode):
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
    ``/tf``                    TFMessage                   with each pose, map to odom (needs tf2_msgs)
    ``~/initialpose``          PoseWithCovarianceStamped   once when the source ``initialpose_for`` falls silent
    ``/diagnostics``           DiagnosticArray             1 Hz
    =========================  ==========================  ===================================================

    Service (Trigger): ``~/reset`` clears the pose and the states of the sources. The parameter ``sources`` has the
    names of the pose sources; each has ``<name>.topic``, ``<name>.sigma_xy`` and so on.
    """

    SETTINGS = (NodeSettings, ArbiterSettings)

    def __init__(self, **options: Any) -> None:
        """Declare the parameters, and start; options are those of ``rclpy.node.Node``.

        Raises:
            SettingsError: a bad parameter, or two parameters that contradict each other.
        """
        super().__init__('pose_arbiter', **options)
        self.start()

    def declare_settings(self) -> None:
        """Declare the parameters, also those of the sources."""
        super().declare_settings()
        self._source_class = declare_sources(self)

    def check_settings(self) -> None:
        """Raise a SettingsError for frames or topics that are the same."""
        settings = self.settings(NodeSettings)
        frames = (settings.map_frame, settings.odom_frame, settings.base_frame)
        if len(set(frames)) < len(frames):
            raise SettingsError(
                'two of map_frame, odom_frame and base_frame are the same; give each frame its own name'
            )
        sources, helped = self._source_settings(), settings.initialpose_for
        reject_shared_topics(self, sources)
        if helped and helped not in sources:
            raise SettingsError(f'setting initialpose_for is {helped!r}, it must be one of {", ".join(sources)}')

    def _source_settings(self) -> dict[str, SourceSettings]:
        return fill_defaults(self.settings(self._source_class), self.settings(NodeSettings).map_frame)

    def configure(self) -> None:
        """Subscribe to the sources."""
        self._settings, self._filter_settings = self.settings(NodeSettings), self.settings(ArbiterSettings)
        sources = self._source_settings()
        self._sources = tuple(sources.values())
        helped = self._settings.initialpose_for
        self._helped = list(sources).index(helped) if helped else None
        self._helped_after: tuple[int, int] | None = None
        self._arbiter = Arbiter(self._sources, self._filter_settings)
        self._clock_monitor = ClockMonitor(self, self._on_clock_jump)
        self._schedule = TickSchedule(self._settings.rate)
        self._report = ArbiterReport(self, self._arbiter, sources, self._clock_monitor.now)
        self._output = ArbiterOutput(self, self._settings)
        self._input = ArbiterInput(self, self._arbiter, sources, self._settings, self._clock_monitor.now)
        create_trigger_service(self, self._guard, '~/reset', self._reset)
        self.create_guarded_timer(1.0 / self._settings.rate, _OUTPUT, self._publish_due)

    def apply_settings(self) -> None:
        """Use changed settings from the next pose on."""
        sources, settings = self._source_settings(), self.settings(ArbiterSettings)
        self._arbiter.apply_settings(tuple(sources.values()), settings)
        self._sources, self._filter_settings = tuple(sources.values()), settings
        self._report.apply_settings(sources)

    def status(self) -> Status:
        """Return the state of the pose and of the sources."""
        return self._report.status()

    def _publish_due(self) -> None:
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
