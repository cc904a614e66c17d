"""What the launch files share: a node with its parameter file, and the inclusion of another launch file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription, OpaqueFunction
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, SetParameter
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchContext, LaunchDescription

ROBOT = {
    'namespace': ('', 'namespace of the robot'),
    'frame_prefix': ('', "prefix of the robot's frames, such as robot1/; map_frame is shared"),
}
"""Launch arguments of every robot: with them, several robots are in one graph."""


REQUIRED = {'stereo_landmark': 'places_dir', 'vlc_beacon': 'beacons_file'}
"""Parameter and launch argument of a node that names a file or folder which it needs."""

OPTIONAL = {
    'floor_localizer': ('map_file',),
    'reward_planner': ('map_file', 'keepout_mask_file', 'speed_mask_file'),
    'vlc_beacon': ('key_file',),
}
"""Parameters that may be empty."""

_FLAG = ['true', 'false', 'True', 'False', '1', '0']
_CHOICES = {'true': _FLAG, 'false': _FLAG, 'auto': [*_FLAG, 'auto']}
"""Values of a flag by its default: a wrong one must stop the launch before a node is started."""


class MissingFileError(Exception):
    """A file that a node needs is missing; the launch stops with this line."""


def share(*parts: str) -> PathJoinSubstitution:
    """Return the path of an installed file of this package."""
    return PathJoinSubstitution([FindPackageShare('shirube_bringup'), *parts])


def declare(arguments: Mapping[str, tuple[Any, str]]) -> list[DeclareLaunchArgument]:
    """Return launch arguments, given default and description of each by name."""
    return [
        DeclareLaunchArgument(name, default_value=default, description=text, choices=_CHOICES.get(default))
        for name, (default, text) in arguments.items()
    ]


def single_node(
    package: str, arguments: Mapping[str, tuple[str, str]], topics: Mapping[str, Any] | None = None, name: str = ''
) -> LaunchDescription:
    """Return a node with its parameter file, and its launch arguments.

    Args:
        package: package of the node.
        arguments: default and description of the launch arguments besides ``params_file`` and ``use_sim_time``; flags,
            and the required file unless it is empty, are parameters of the node that win over the parameter file.
        topics: remapped topics; by default those of the arguments' names.
        name: name of the node, its executable and its parameter file; empty for the package's and `node`.
    """

    def start_node(context: LaunchContext) -> list[Node]:
        switched = [{flag: ParameterValue(LaunchConfiguration(flag), value_type=bool)} for flag in flags]
        given = {path: LaunchConfiguration(path).perform(context) for path in file}
        params_file = Path(LaunchConfiguration('params_file').perform(context))
        check_files(name or package, params_file, given)
        prefix, trees = frame_prefix(context)
        parameters = [*switched, *prefix, *({key: path} for key, path in given.items() if path)]
        return [
            Node(
                package=package,
                executable=name or 'node',
                name=name or package,
                exec_name=name or package,  # in the log, instead of the executable's
                namespace=LaunchConfiguration('namespace'),
                output='screen',
                parameters=[LaunchConfiguration('params_file'), *parameters],
                remappings=[*remapped.items(), *trees],
            )
        ]

    flags = [each for each, (default, _) in arguments.items() if default in _CHOICES]
    file = [REQUIRED[package]] if package in REQUIRED else []
    own = [each for each in arguments if each not in (*flags, *file)]
    remapped = {each: LaunchConfiguration(each) for each in own} if topics is None else topics
    params_file = {'params_file': (share('config', f'{name or package}.yaml'), 'parameters of the node')}
    declared = declare({**params_file, **arguments, **ROBOT, 'use_sim_time': ('false', 'use /clock')})
    sim_time = SetParameter('use_sim_time', True, condition=IfCondition(LaunchConfiguration('use_sim_time')))
    return LaunchDescription([*declared, sim_time, OpaqueFunction(function=start_node)])


def frame_prefix(context: LaunchContext) -> tuple[list[dict[str, str]], list[tuple[str, str]]]:
    """Return parameters and remapped topics; robots with the same frames need a tree each, the others share one."""
    prefix = LaunchConfiguration('frame_prefix').perform(context)
    return ([{'frame_prefix': prefix}], []) if prefix else ([], [('/tf', 'tf'), ('/tf_static', 'tf_static')])


def check_files(node: str, params_file: Path, given: Mapping[str, str]) -> None:
    """Raise a MissingFileError if a node's parameter file, or a file that it or an argument names, is missing.

    ROS launch does not end the nodes that it has started before an error: check all files first.
    """
    if not params_file.is_file():
        raise MissingFileError(f'params_file {params_file} does not exist; give the absolute path of your copy')
    required = REQUIRED.get(node)
    for name in filter(None, (required, *OPTIONAL.get(node, ()))):
        path = given.get(name) or parameter_in(params_file, name)
        check_path(name, path)
        if not path and name == required:
            raise MissingFileError(f'{name} is not set; give {name}:=PATH, or set it in {params_file}')


def check_path(name: str, path: str) -> None:
    """Raise a MissingFileError if the file or folder of an argument is missing; an empty path is none."""
    if path and not Path(path).exists():
        raise MissingFileError(f'{name} {path} does not exist; give an absolute path')


def parameter_in(params_file: Path, name: str) -> str:
    """Return a parameter that a parameter file sets for any node, or an empty string."""
    try:
        content = yaml.safe_load(params_file.read_text())
    except (OSError, UnicodeError, yaml.YAMLError):
        return ''  # the node names file and line
    return next((str(value) for value in _values_of(content, name) if value), '')


def _values_of(content: object, name: str) -> Iterator[object]:
    if isinstance(content, Mapping):
        for key, value in content.items():
            yield from [value] if key == name else _values_of(value, name)


def include(
    name: str, package: str, folder: Any, use_sim_time: Any, condition: str | None = None, **arguments: Any
) -> GroupAction:
    """Include another launch file of this package, with its parameter file from a folder.

    The group limits the scope of the arguments; otherwise they would also be set for the next files, which have
    arguments of the same name.
    """
    arguments['params_file'] = PathJoinSubstitution([folder, f'{package}.yaml'])
    arguments['use_sim_time'] = use_sim_time
    source = PythonLaunchDescriptionSource(share('launch', f'{name}.launch.py'))
    part = IncludeLaunchDescription(source, launch_arguments=arguments.items())
    return GroupAction([part], condition=IfCondition(LaunchConfiguration(condition)) if condition else None)
