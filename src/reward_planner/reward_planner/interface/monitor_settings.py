"""Parameters of the node collision_monitor that are not those of its core, and the parameters of its sources."""

import re
from dataclasses import dataclass, field, make_dataclass
from keyword import iskeyword

from rcl_interfaces.msg import ParameterDescriptor

from reward_planner.core.safety.safety_settings import SourceSettings
from shirube_core.settings import SettingsError, setting
from shirube_ros.managed_node import ManagedNode

DEFAULT_SOURCES = ('front',)
_PARAMETER = 'sources'


@dataclass(frozen=True)
class MonitorNodeSettings:
    """Frame and type of the velocities."""

    base_frame: str = setting('base_link', 'frame of the robot')
    stamped: bool = setting(
        True, 'whether cmd_vel_in and cmd_vel are TwistStamped rather than Twist, as in motor_bridge'
    )


def declare_sources(node: ManagedNode) -> type:
    """Declare ``sources`` and the parameters of each one; return the class of their settings, one group a source.

    Raises:
        SettingsError: no names, an invalid or duplicate name, or an invalid value.
    """
    descriptor = ParameterDescriptor(
        description='names of the range sensors; each has the parameters <name>.type and so on', dynamic_typing=True
    )
    value = node.declare_parameter(_PARAMETER, list(DEFAULT_SOURCES), descriptor).value
    names = [str(name) for name in value] if isinstance(value, (list, tuple)) else []
    if not names or len(set(names)) < len(names):
        raise SettingsError(f'setting {_PARAMETER} is {value!r}; give a list of different names, such as [front]')
    for name in names:
        if not re.fullmatch(r'[a-z][a-z0-9_]*', name) or iskeyword(name) or node.has_parameter(name):
            raise SettingsError(
                f'setting {_PARAMETER} holds {name!r}; a name has lower-case letters, digits and underscores, '
                'and is no keyword and no parameter'
            )
    groups = make_dataclass(
        'SourceGroups', [(name, SourceSettings, field(default_factory=SourceSettings)) for name in names], frozen=True
    )
    node.declare(groups)
    return groups
