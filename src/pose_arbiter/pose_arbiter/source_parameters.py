"""The parameter ``sources`` and the group of parameters that each of its names has."""

from __future__ import annotations

import re
from dataclasses import field, make_dataclass, replace
from keyword import iskeyword
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_topic_name import validate_topic_name

from pose_arbiter.core.source_settings import SourceSettings
from shirube_ros.parameters import declare_parameters
from shirube_settings import SettingsError

DEFAULT_SOURCES = ('floor_localizer', 'stereo_landmark', 'vlc_beacon')
"""The localizers of this suite, whose topics are known."""
_PARAMETER = 'sources'
_OTHER_WORDS = ('odom', 'initialpose', 'output', 'state', 'sigma')  # in the diagnostics


def declare_sources(node: Node, map_frame: str) -> dict[str, SourceSettings]:
    """Declare the parameters of the sources and return what the user set, by name, with topics and frames filled in.

    Args:
        node: the node that gets the parameters.
        map_frame: the frame of poses where no other is set.

    Raises:
        SettingsError: no names, a bad or doubled one, a topic that is none, is taken or our own, or a bad value.
    """
    names = _names(node)
    groups = make_dataclass(
        'SourceGroups',
        [(name, SourceSettings, field(default_factory=SourceSettings)) for name in names],
        frozen=True,
    )
    settings: Any = declare_parameters(node, groups)
    sources = {name: _filled(name, getattr(settings, name), map_frame) for name in names}
    _refuse_shared_topics(node, sources)
    return sources


def _names(node: Node) -> list[str]:
    descriptor = ParameterDescriptor(
        description='names of the sources of poses; each has its parameters <name>.topic and so on',
        dynamic_typing=True,
    )
    value = node.declare_parameter(_PARAMETER, list(DEFAULT_SOURCES), descriptor).value
    if not isinstance(value, (list, tuple)) or not all(isinstance(name, str) for name in value) or not value:
        raise SettingsError(
            f'setting {_PARAMETER} is {value!r}, it must be a list of names, such as [floor, lamps]'
        )
    names = [str(name) for name in value]
    for name in names:
        if not re.fullmatch(r'[a-z][a-z0-9_]*', name) or iskeyword(name):
            raise SettingsError(
                f'setting {_PARAMETER} holds {name!r}; a name has small letters, digits and underscores '
                'and is no word of Python'
            )
        if names.count(name) > 1:
            raise SettingsError(
                f'setting {_PARAMETER} holds {name} twice; give each source a name of its own'
            )
        if node.has_parameter(name):
            raise SettingsError(f'setting {_PARAMETER} holds {name}, which is a parameter; take another name')
        if name in _OTHER_WORDS:
            raise SettingsError(
                f'setting {_PARAMETER} holds {name}, which is something else in the diagnostics; take another name'
            )
    return names


def _filled(name: str, source: SourceSettings, map_frame: str) -> SourceSettings:
    usual = f'/{name}/pose_with_covariance' if source.with_covariance else f'/{name}/pose'
    return replace(source, topic=source.topic or usual, frame=source.frame or map_frame)


def _refuse_shared_topics(node: Node, sources: dict[str, SourceSettings]) -> None:
    own = {node.resolve_topic_name(topic) for topic in ('~/pose', '~/odometry')}
    owners: dict[str, str] = {}
    for name, source in sources.items():
        topic = _resolved(node, name, source.topic)
        if topic in own:
            raise SettingsError(
                f'setting {name}.topic is {topic}, what this node tells itself; take a localizer'
            )
        if topic in owners:
            raise SettingsError(
                f'sources {owners[topic]} and {name} have the same topic {topic}; one opinion may not count twice'
            )
        owners[topic] = name


def _resolved(node: Node, name: str, topic: str) -> str:
    try:
        validate_topic_name(topic)
    except InvalidTopicNameException as error:
        raise SettingsError(f'setting {name}.topic is {topic!r}, which is no name of a topic') from error
    return str(node.resolve_topic_name(topic))
