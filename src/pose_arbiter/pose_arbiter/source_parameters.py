"""The parameter ``sources`` and the parameters ``<name>.topic`` and so on of each source."""

import re
from dataclasses import field, fields, make_dataclass, replace
from keyword import iskeyword
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_topic_name import validate_topic_name

from pose_arbiter.core.settings import SourceSettings
from shirube_core.settings import SettingsError
from shirube_ros.managed_node import ManagedNode

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
