"""What the launch files share: a node with its parameter file, and the inclusion of another launch file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription, OpaqueFunction
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, SetParameter
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchContext, LaunchDescription


def share(*parts: str) -> PathJoinSubstitution:
    """Return the path of an installed file of this package."""
    return PathJoinSubstitution([FindPackageShare('shirube_bringup'), *parts])


def declare(arguments: Mapping[str, tuple[Any, str]]) -> list[DeclareLaunchArgument]:
    """Return launch arguments, given default and description of each by name."""
    return [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in arguments.items()
    ]


def single_node(
    package: str,
    arguments: Mapping[str, tuple[str, str]],
    topics: Mapping[str, Any] | None = None,
    *,
    flags: Sequence[str] = (),
    paths: Sequence[str] = (),
) -> LaunchDescription:
    """Return a node with its parameter file, and its launch arguments.

    Args:
        package: package of the node, which is also its name and that of its parameter file.
        arguments: default and description of the launch arguments besides ``params_file`` and ``use_sim_time``.
        topics: remapped topics; by default those of the arguments' names.
        flags: arguments that are boolean parameters of the node; they have precedence over the parameter file.
        paths: arguments that are parameters of the node unless they are empty.
    """

    def start_node(context: LaunchContext) -> list[Node]:
        switched = [{name: ParameterValue(LaunchConfiguration(name), value_type=bool)} for name in flags]
        given = {name: LaunchConfiguration(name).perform(context) for name in paths}
        return [
            Node(
                package=package,
                executable='node',
                name=package,
                output='screen',
                parameters=[
                    LaunchConfiguration('params_file'),
                    *switched,
                    *({name: path} for name, path in given.items() if path),
                ],
                remappings=list(remapped.items()),
            )
        ]

    names = [name for name in arguments if name not in (*flags, *paths)]
    remapped = {name: LaunchConfiguration(name) for name in names} if topics is None else topics
    declared = declare(
        {
            'params_file': (share('config', f'{package}.yaml'), 'parameters of the node'),
            **arguments,
            'use_sim_time': ('false', 'use /clock'),
        }
    )
    sim_time = SetParameter('use_sim_time', True, condition=IfCondition(LaunchConfiguration('use_sim_time')))
    return LaunchDescription([*declared, sim_time, OpaqueFunction(function=start_node)])


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
