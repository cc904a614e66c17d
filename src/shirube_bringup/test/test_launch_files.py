"""ROS's launch system is not on PyPI, so the launch files are read here, not run."""

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

PACKAGE = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize(
    ('launch', 'config'),
    [
        ('arbiter', 'pose_arbiter'),
        ('bridge', 'motor_bridge'),
        ('floor', 'floor_localizer'),
        ('planner', 'reward_planner'),
        ('stereo', 'stereo_landmark'),
        ('vlc', 'vlc_beacon'),
    ],
)
def test_launch_file_starts_the_node_that_the_parameter_file_is_for(launch: str, config: str) -> None:
    tree = ast.parse((PACKAGE / 'launch' / f'{launch}.launch.py').read_text())
    node = next(c for c in ast.walk(tree) if isinstance(c, ast.Call) and getattr(c.func, 'id', '') == 'Node')
    named = {k.arg: k.value.value for k in node.keywords if isinstance(k.value, ast.Constant)}
    parameters = yaml.safe_load((PACKAGE / 'config' / f'{config}.yaml').read_text())
    assert named['package'] in (PACKAGE / 'package.xml').read_text()
    assert list(parameters) == [named['name']]
    assert list(parameters[named['name']]) == ['ros__parameters']


def strings_in(value: object) -> Iterator[str]:
    """Yield every key and every text of a file that was read."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from strings_in(key)
            yield from strings_in(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from strings_in(inner)


NODES = ('floor_localizer', 'stereo_landmark', 'vlc_beacon', 'reward_planner', 'pose_arbiter')


@pytest.mark.parametrize('path', ['rviz/shirube.rviz', 'foxglove/shirube.json'])
def test_shown_topics_are_published_by_the_nodes(path: str) -> None:
    text = (PACKAGE / path).read_text()
    read = json.loads(text) if path.endswith('json') else yaml.safe_load(text)
    shown = {s for s in strings_in(read) if re.match(rf'/({"|".join(NODES)})/', s)}
    assert {topic.split('/')[1] for topic in shown} == set(NODES)
    for topic in shown - {s for s in shown if s.endswith('_updates')}:
        package, name = topic.split('/')[1:3]
        source = ''.join(p.read_text() for p in (PACKAGE.parent / package / package).glob('*.py'))
        assert f"'~/{name}'" in source, topic


def test_the_foxglove_layout_shows_every_topic_of_the_nodes() -> None:
    layout = json.loads((PACKAGE / 'foxglove' / 'shirube.json').read_text())
    shown = {re.split(r'[.\[]', text)[0] for text in strings_in(layout['configById'])}
    wanted = {'/cmd_vel', '/estop', '/odom', '/joint_states', '/diagnostics', '/goal_pose', '/initialpose'}
    for node in NODES:
        for source in (PACKAGE.parent / node / node).glob('*.py'):
            matches = re.findall(r"(?:create_publisher|MapPublisher)\(\s*\S+, '~/(\w+)'", source.read_text())
            wanted |= {f'/{node}/{name}' for name in matches if name != 'cmd_vel'}
    assert len(wanted) > 20
    assert wanted <= shown
    panels = set(strings_in(layout['layout']))
    assert set(layout['configById']) <= panels


@pytest.mark.parametrize('launch', ['robot', 'simulation'])
def test_every_included_launch_file_is_there_and_takes_what_it_is_given(launch: str) -> None:
    tree = ast.parse((PACKAGE / 'launch' / f'{launch}.launch.py').read_text())
    calls = [c for c in ast.walk(tree) if isinstance(c, ast.Call) and getattr(c.func, 'id', '') == 'include']
    assert len(calls) == 6
    for call in calls:
        name, package = (a.value for a in call.args[:2])
        included = (PACKAGE / 'launch' / f'{name}.launch.py').read_text()
        assert f"package='{package}'" in included
        given = {k.arg for k in call.keywords if k.arg} | {'params_file', 'use_sim_time'}
        for argument in given | ({'image', 'camera_info'} if name in {'floor', 'vlc'} else set()):
            assert re.search(rf"DeclareLaunchArgument\(\s*'{argument}'", included), (name, argument)


@pytest.mark.parametrize('launch', ['robot', 'simulation'])
def test_what_one_part_is_given_does_not_reach_the_next(launch: str) -> None:
    # Arguments of an included file stay set for the next files, unless the file is in its own group.
    tree = ast.parse((PACKAGE / 'launch' / f'{launch}.launch.py').read_text())
    include = next(f for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) and f.name == 'include')
    group = include.body[-1].value
    assert group.func.id == 'GroupAction'
    assert not any(word.arg == 'scoped' for word in group.keywords)
    assert [ast.unparse(part) for part in group.args] == ['[part]']


@pytest.mark.parametrize('launch', ['arbiter', 'bridge', 'floor', 'planner', 'stereo', 'vlc'])
def test_an_argument_that_is_empty_by_default_leaves_the_parameter_file_alone(launch: str) -> None:
    calls = [
        c
        for c in ast.walk(ast.parse((PACKAGE / 'launch' / f'{launch}.launch.py').read_text()))
        if isinstance(c, ast.Call)
    ]
    empty = {
        c.args[0].value
        for c in calls
        if getattr(c.func, 'id', '') == 'DeclareLaunchArgument'
        and any(k.arg == 'default_value' and getattr(k.value, 'value', None) == '' for k in c.keywords)
    }
    node = next(c for c in calls if getattr(c.func, 'id', '') == 'Node')
    handed_over = {
        ast.unparse(c.args[0]).strip("'")
        for c in ast.walk(node)
        if isinstance(c, ast.Call) and getattr(c.func, 'id', '') == 'LaunchConfiguration'
    }
    assert not empty & handed_over


def test_the_simulation_gives_all_that_an_included_launch_file_demands() -> None:
    tree = ast.parse((PACKAGE / 'launch' / 'simulation.launch.py').read_text())
    calls = [c for c in ast.walk(tree) if isinstance(c, ast.Call) and getattr(c.func, 'id', '') == 'include']
    for call in calls:
        included = ast.parse((PACKAGE / 'launch' / f'{call.args[0].value}.launch.py').read_text())
        declared = (
            c
            for c in ast.walk(included)
            if isinstance(c, ast.Call) and getattr(c.func, 'id', '') == 'DeclareLaunchArgument'
        )
        demanded = {
            c.args[0].value for c in declared if not any(k.arg == 'default_value' for k in c.keywords)
        }
        assert demanded <= {k.arg for k in call.keywords}


def test_the_replay_starts_the_player_with_known_options() -> None:
    replay = (PACKAGE / 'launch' / 'replay.launch.py').read_text()
    play = (PACKAGE.parent / 'shirube_bags' / 'shirube_bags' / 'commands' / 'play.py').read_text()
    options = re.findall(r"'(--[\w-]+)'", replay)
    assert options
    assert all(f"'{option}'" in play for option in options)


def test_the_simulation_starts_the_room_with_known_options() -> None:
    simulation = (PACKAGE / 'launch' / 'simulation.launch.py').read_text()
    mission = PACKAGE.parent / 'shirube_bringup'
    assert 'room = {NAME}.commands.room:main' in (mission / 'setup.py').read_text()
    room = (mission / 'shirube_bringup' / 'commands' / 'room.py').read_text()
    run = (mission / 'shirube_bringup' / 'run.py').read_text()
    for option in re.findall(r"'(--\w+)'", simulation):
        assert f"'{option}'" in room
    (matches,) = re.findall(r"^WRITTEN = b'(.+)'$", simulation, re.MULTILINE)
    assert re.search(rf"^PARAMETERS_WRITTEN = '.*{matches}", run, re.MULTILINE)
    topics = re.findall(r"camera\('(\w+)'\)", simulation)
    publishers = (mission / 'shirube_bringup' / 'publishers.py').read_text()
    assert topics
    assert all(f"'/{name}/image_raw'" in publishers for name in topics)


def test_one_driver_at_most_can_be_launched() -> None:
    text = (PACKAGE / 'launch' / 'robot.launch.py').read_text()
    assert "choices=['none', 'planner', 'lamps']" in text
    assert text.count("EqualsSubstitution(given('driver')") == text.count('drive=') == 2
