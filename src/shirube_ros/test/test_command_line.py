"""The command line of a node: stray arguments, parameter files for other nodes, mixed lists, help."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from shirube_core.settings import setting, tunable
from shirube_ros.command_line import CommandLineError, check_arguments, help_text, wants_help
from shirube_ros.managed_node import ManagedNode

FILE = '{name}:\n  ros__parameters:\n    rate: 0.5\n'
ROBOT = ['-r', '__ns:=/robot_1']


@tunable()
@dataclass(frozen=True)
class ScalerSettings:
    factor: float = setting(2.0, 'factor', limits=(0.0, 10.0))


class Scaler(ManagedNode):
    """Publishes what it receives, scaled.

    ``number``  with ``factor`` applied
    """

    SETTINGS = (ScalerSettings,)


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['map.csv'], r"^argument 'map.csv' has no effect; .* --ros-args -p name:=map.csv"),
        (['--ros-args', '-p', 'a:=1', '--', 'map.csv'], "^argument 'map.csv' has no effect"),
        (['-p', 'file:=x'], '^-p file:=x has no effect here; write --ros-args -p file:=x'),
        (['--ros-args', '-p', 'xyz:=[0,0,0.13]'], r'^-p xyz is \[0, 0, 0.13\], .* write \[0.0, 0.0, 0.13\]'),
    ],
)
def test_what_rcl_would_ignore_is_refused_with_the_remedy(arguments: list[str], words: str) -> None:
    with pytest.raises(CommandLineError, match=words):
        check_arguments('scaler', arguments)


@pytest.mark.parametrize(
    'arguments',
    [
        [],
        ['--ros-args', '-p', 'xyz:=[0,1,2]', '-p', 'abc:=[0.5, 1e-3]', '-p', "words:=[a, '1', '2.0']"],
        ['--ros-args', '-r', 'a:=b', '--log-level', 'debug', '-p', 'scaler:a:=1', '--'],
        ['--ros-args', '--params-file', 'no_such_file.yaml'],  # rcl says so
    ],
)
def test_what_rcl_takes_is_left_to_it(arguments: list[str]) -> None:
    assert check_arguments('scaler', arguments) == []


@pytest.mark.parametrize(
    ('names', 'more', 'refused', 'warned'),
    [
        (['scaler'], [], False, 0),
        (['/scaler'], [], False, 0),
        (['/**'], ROBOT, False, 0),
        (['/*/scaler'], ROBOT, False, 0),
        (['/robot_1/scaler'], ROBOT, False, 0),
        (['other', 'scaler'], [], False, 0),
        (['other'], ['-r', '__node:=other'], False, 0),
        (['scaler'], ROBOT, True, 0),
        (['other', '/robot_1/other'], [], True, 0),
        (['/*/scaler'], [], True, 0),
        (['/**', 'scaler'], ROBOT, False, 1),
    ],
)
def test_a_file_for_other_nodes_is_refused_and_unused_parts_are_named(
    tmp_path: Path, names: list[str], more: list[str], refused: bool, warned: int
) -> None:
    file = tmp_path / 'robot.yaml'
    file.write_text(''.join(FILE.format(name=name) for name in names))
    arguments = ['--ros-args', '--params-file', str(file), *more]
    if refused:
        name = '/robot_1/scaler' if more else '/scaler'
        with pytest.raises(CommandLineError, match=f'{names[0].strip("/*")}.* this node is {name};'):
            check_arguments('scaler', arguments)
    else:
        assert len(check_arguments('scaler', arguments)) == warned


def test_nested_names_and_lists_in_files_are_read(tmp_path: Path) -> None:
    file = tmp_path / 'robot.yaml'
    file.write_text('robot_1:\n  scaler:\n    ros__parameters:\n      mount: {xyz: [0, 0, 0.13]}\n')
    arguments = ['--ros-args', '--params-file', str(file), *ROBOT]
    with pytest.raises(CommandLineError, match=r'robot.yaml: mount.xyz is \[0, 0, 0.13\], which mixes'):
        check_arguments('scaler', arguments)


def test_help_names_use_and_parameters() -> None:
    assert wants_help('scaler', ['--help'])
    assert wants_help('scaler', ['-h', '--ros-args', '-p', 'a:=1'])
    assert not wants_help('scaler', ['--ros-args', '-p', 'text:=--help'])
    text = help_text('scaler', Scaler)
    assert 'Publishes what it receives, scaled.\n\nnumber      with factor applied\n' in text
    assert '\n *factor (2.0; 0 to 10): factor\n' in text
    assert '\n  autostart (True): ' in text
