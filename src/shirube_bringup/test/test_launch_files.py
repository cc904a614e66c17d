"""ROS's launch system is not on PyPI, so the launch files run here on a stand-in that stores what they build."""

import importlib.util
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml

PACKAGE = Path(__file__).resolve().parents[1]
SINGLE = {'arbiter': 'pose_arbiter', 'bridge': 'motor_bridge', 'camera': 'camera', 'floor': 'floor_localizer'}
SINGLE |= {
    'monitor': 'collision_monitor',
    'planner': 'reward_planner',
    'stereo': 'stereo_landmark',
    'vlc': 'vlc_beacon',
}


class Built:
    """An action or substitution with its arguments; a substitution is performed by looking into the context."""

    def __init__(self, *args: Any, **named: Any) -> None:
        self.kind, self.args, self.named = type(self).__name__, args, named

    def perform(self, context: dict[str, str]) -> str:
        return context[self.args[0]]


class StandIn(ModuleType):
    """A module in which every name is a class of its own."""

    __path__ = ()

    def __getattr__(self, name: str) -> type[Built]:
        if name.startswith('__'):
            raise AttributeError(name)
        made = type(name, (Built,), {})
        setattr(self, name, made)
        return made


@pytest.fixture(autouse=True)
def _launch_system(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    inner = 'actions conditions event_handlers events events.process launch_description_sources substitutions'
    names = [f'launch.{n}' for n in inner.split()]
    names += [f'launch_ros.{n}' for n in ('actions', 'parameter_descriptions', 'substitutions')]
    for name in ('launch', 'launch_ros', *names):
        monkeypatch.setitem(sys.modules, name, StandIn(name))
    yield
    sys.modules.pop('shirube_bringup.launching', None)


def load(name: str) -> ModuleType:
    """Return a launch file as a module."""
    path = PACKAGE / 'launch' / f'{name}.launch.py'
    spec = importlib.util.spec_from_file_location(f'{name}_launch', path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def actions_of(name: str) -> list[Built]:
    return load(name).generate_launch_description().args[0]


def declared_in(name: str) -> dict[str, Any]:
    """Return the default of each launch argument; None for one that must be given."""
    return {a.args[0]: a.named.get('default_value') for a in actions_of(name) if a.kind == 'DeclareLaunchArgument'}


def node_of(name: str, **given: str) -> dict[str, Any]:
    """Return the arguments of the node that a launch file starts."""
    (start,) = (a.named['function'] for a in actions_of(name) if a.kind == 'OpaqueFunction')
    files = {'params_file': str(PACKAGE / 'config' / f'{SINGLE[name]}.yaml')}
    files |= {inner: str(PACKAGE) for inner in ('places_dir', 'beacons_file') if inner in declared_in(name)}
    (node,) = start({**declared_in(name), **files, **given})
    return node.named


def configurations_in(value: Any) -> set[str]:
    """Return the launch arguments that a value is made from."""
    if isinstance(value, Built):
        own = {value.args[0]} if value.kind == 'LaunchConfiguration' else set()
        return own | configurations_in((value.args, value.named))
    if isinstance(value, dict):
        return configurations_in(list(value.values()))
    if isinstance(value, list | tuple):
        return {name for inner in value for name in configurations_in(inner)}
    return set()


@pytest.mark.parametrize('launch', SINGLE)
def test_launch_file_starts_the_node_that_the_parameter_file_is_for(launch: str) -> None:
    node, name = node_of(launch), SINGLE[launch]
    parameters = yaml.safe_load((PACKAGE / 'config' / f'{name}.yaml').read_text())
    package = {'monitor': 'reward_planner', 'camera': 'shirube_camera'}.get(launch, name)
    executable = name if package != name else 'node'
    assert (node['package'], node['name'], node['executable']) == (package, name, executable)
    assert node['exec_name'] == name
    assert package in (PACKAGE / 'package.xml').read_text()
    assert list(parameters) == ['/**']
    assert list(parameters['/**']) == ['ros__parameters']
    defaults = declared_in(launch)
    assert defaults['params_file'].args[0][1:] == ['config', f'{name}.yaml']
    assert [*defaults][:: len(defaults) - 1] == ['params_file', 'use_sim_time']
    (sim_time,) = (a for a in actions_of(launch) if a.kind == 'SetParameter')
    assert sim_time.args == ('use_sim_time', True)
    assert configurations_in(sim_time) == {'use_sim_time'}


@pytest.mark.parametrize('launch', SINGLE)
def test_every_argument_reaches_the_node_and_an_empty_one_leaves_the_file_alone(launch: str) -> None:
    empty = {name for name, default in declared_in(launch).items() if default == ''} - {'namespace'}
    assert configurations_in(node_of(launch)) == set(declared_in(launch)) - empty - {'use_sim_time'}
    first, *others = node_of(launch, **dict.fromkeys(empty, str(PACKAGE)))['parameters']
    assert first.args == ('params_file',)
    unset = dict.fromkeys(empty - {'places_dir', 'beacons_file'}, '')
    assert not unset.keys() & {name for one in node_of(launch, **unset)['parameters'][1:] for name in one}
    assert {name for one in others for name, value in one.items() if value == str(PACKAGE)} == empty


def test_robots_with_a_prefix_share_a_tree_and_others_have_their_own() -> None:
    trees = {'/tf': 'tf', '/tf_static': 'tf_static'}
    for launch in SINGLE:
        assert trees.items() <= dict(node_of(launch)['remappings']).items()
        assert not trees.keys() & dict(node_of(launch, frame_prefix='robot1/')['remappings']).keys()


@pytest.mark.parametrize(
    ('launch', 'given', 'words'),
    [
        ('bridge', {'params_file': '/no/where.yaml'}, 'params_file /no/where.yaml does not exist'),
        ('stereo', {'places_dir': ''}, 'places_dir is not set; give places_dir:=PATH, or set it in .*yaml'),
        ('vlc', {'beacons_file': '/no/where.yaml'}, 'beacons_file /no/where.yaml does not exist'),
    ],
)
def test_a_missing_file_stops_the_launch(launch: str, given: dict[str, str], words: str) -> None:
    with pytest.raises(Exception, match=words) as caught:
        node_of(launch, **given)
    assert (type(caught.value).__name__, str(caught.value).count('\n')) == ('MissingFileError', 0)


def test_a_missing_map_of_the_parameter_file_stops_the_launch(tmp_path: Path) -> None:
    file = tmp_path / 'planner.yaml'
    file.write_text('/**:\n  ros__parameters:\n    map_file: /no/map.yaml\n')
    with pytest.raises(Exception, match=r'map_file /no/map\.yaml does not exist'):
        node_of('planner', params_file=str(file))


class Context(dict[str, str]):
    """Launch arguments, in both ways of access."""

    @property
    def launch_configurations(self) -> dict[str, str]:
        return self


def test_a_localizer_without_its_file_is_left_out_with_a_line_unless_it_is_asked_for() -> None:
    (choice,) = (a.named['function'] for a in actions_of('robot') if a.kind == 'OpaqueFunction')
    defaults = declared_in('robot') | {'config': str(PACKAGE / 'config'), 'places_dir': str(PACKAGE)}
    context = Context(defaults)
    (line,) = choice(context)
    assert (context['stereo'], context['vlc']) == ('true', 'false')
    assert line.named['msg'].startswith('vlc_beacon is left out, as beacons_file is not set; give beacons_file:=')
    context = Context(defaults | {'stereo': 'false', 'vlc': 'true', 'beacons_file': str(PACKAGE)})
    assert choice(context) == []
    assert (context['stereo'], context['vlc']) == ('false', 'true')


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        ({'description': '/no/robot.xacro'}, 'description /no/robot.xacro does not exist'),
        ({'config': '/no'}, 'params_file /no/floor_localizer.yaml does not exist'),
        ({'floor': '0', 'planner': 'False', 'config': '/no'}, 'params_file /no/pose_arbiter.yaml'),
        ({'vlc': '1'}, 'beacons_file is not set'),
        ({'stereo': 'true', 'places_dir': '/no/places'}, 'places_dir /no/places does not exist'),
    ],
)
def test_the_files_of_all_parts_are_checked_before_a_node_starts(given: dict[str, str], words: str) -> None:
    kinds = [action.kind for action in actions_of('robot')]
    assert max(i for i, kind in enumerate(kinds) if kind == 'OpaqueFunction') < kinds.index('GroupAction')
    (choose,) = (a.named['function'] for a in actions_of('robot') if a.kind == 'OpaqueFunction')
    defaults = declared_in('robot') | {'config': str(PACKAGE / 'config')}
    assert len(choose(Context(defaults))) == 2
    with pytest.raises(Exception, match=words) as caught:
        choose(Context(defaults | given))
    assert type(caught.value).__name__ == 'MissingFileError'


def test_the_cameras_that_are_asked_for_start_in_their_namespaces(tmp_path: Path) -> None:
    for name in [*(file.name for file in (PACKAGE / 'config').iterdir()), 'belly_camera.yaml', 'stereo_camera.yaml']:
        (tmp_path / name).touch()
    (choose,) = (a.named['function'] for a in actions_of('robot') if a.kind == 'OpaqueFunction')
    given = declared_in('robot') | {'config': str(tmp_path), 'cameras': 'belly stereo'}
    started = [a.args[0][0].named['launch_arguments'] for a in choose(Context(given)) if a.kind != 'LogInfo']
    files = [dict(each)['params_file'].args[0][1] for each in started]
    assert files == ['belly_camera.yaml', 'stereo_camera.yaml']
    assert [dict(each)['namespace'][1:] for each in started] == [['/', 'belly'], []]
    with pytest.raises(Exception, match=r'rear_camera\.yaml does not exist'):
        choose(Context(given | {'cameras': 'rear'}))


def test_a_replay_without_its_bag_and_a_wrong_flag_start_no_node() -> None:
    kinds = [action.kind for action in actions_of('replay')]
    assert kinds.index('OpaqueFunction') < kinds.index('IncludeLaunchDescription')
    (check,) = (a.named['function'] for a in actions_of('replay') if a.kind == 'OpaqueFunction')
    check({'bag': str(PACKAGE)})
    with pytest.raises(Exception, match='bag /no/bag does not exist'):
        check({'bag': '/no/bag'})
    for launch in ('robot', *SINGLE):
        for action in actions_of(launch):
            default, choices = (action.named.get(name) for name in ('default_value', 'choices'))
            assert (default in ('true', 'false', 'auto')) <= (default in (choices or ()))


def test_topics_are_remapped_to_the_given_ones() -> None:
    remapped = {name: dict(node_of(name, frame_prefix='robot1/')['remappings']) for name in SINGLE}
    defaults = [*declared_in('arbiter').values(), *declared_in('planner').values()]
    assert not any(str(default).startswith('/') for default in defaults)  # a namespace is that of the whole robot
    assert remapped['arbiter'].keys() == {'odom', 'initialpose'}
    assert remapped['bridge'].keys() == {'cmd_vel', 'estop'}
    assert remapped['planner'].keys() == {'points', 'pose', 'command', 'cmd_vel'}
    assert remapped['floor']['image_raw'].args == remapped['vlc']['image_raw'].args == ('image',)
    assert remapped['vlc']['~/cmd_vel'].args == ('cmd_vel',)
    sides = [f'{side}/{name}' for side in ('left', 'right') for name in ('image_rect', 'camera_info')]
    assert remapped['stereo'].keys() == {*sides, 'imu'}
    camera, slash, image = remapped['stereo']['left/image_rect']
    assert (camera.args, slash, image.args) == (('left',), '/', ('image',))


@pytest.mark.parametrize('launch', ['robot', 'simulation'])
def test_every_included_launch_file_is_there_and_takes_what_it_is_given(launch: str) -> None:
    groups = load(launch).parts()
    names = []
    for group in groups:
        # Arguments of an included file stay set for the next files, unless the file is in its own group.
        assert (group.kind, group.named.get('scoped')) == ('GroupAction', None)
        ((part,),) = group.args
        path = part.args[0].args[0].args[0]
        names.append(path[-1].removesuffix('.launch.py'))
        given = dict(part.named['launch_arguments'])
        assert given['params_file'].args[0][1] == f'{SINGLE[names[-1]]}.yaml'
        declared = declared_in(names[-1])
        assert given.keys() <= declared.keys()
        assert {name for name, default in declared.items() if default is None} <= given.keys()
        assert configurations_in(given) <= declared_in(launch).keys()
    assert sorted(names) == sorted({*SINGLE} - {'camera'})


def test_the_replay_starts_the_player_with_known_options() -> None:
    replay = (PACKAGE / 'launch' / 'replay.launch.py').read_text()
    assert configurations_in(actions_of('replay')) == declared_in('replay').keys()
    play = (PACKAGE.parent / 'shirube_bags' / 'shirube_bags' / 'commands' / 'play.py').read_text()
    options = re.findall(r"'(--[\w-]+)'", replay)
    assert options
    assert all(f"'{option}'" in play for option in options)


def test_the_simulation_starts_the_room_with_known_options() -> None:
    simulation = (PACKAGE / 'launch' / 'simulation.launch.py').read_text()
    mission = PACKAGE.parent / 'shirube_bringup'
    assert 'room = shirube_bringup.commands.room:main' in (mission / 'setup.cfg').read_text()
    room = (mission / 'shirube_bringup' / 'commands' / 'room.py').read_text()
    run = (mission / 'shirube_bringup' / 'run.py').read_text()
    for option in re.findall(r"'(--\w+)'", simulation):
        assert f"'{option}'" in room
    (matches,) = re.findall(r"^WRITTEN = b'(.+)'$", simulation, re.MULTILINE)
    assert re.search(rf"^PARAMETERS_WRITTEN = '.*{matches}", run, re.MULTILINE)
    topics = re.findall(r"camera\('(\w+)'\)", simulation)
    publishers = (mission / 'shirube_bringup' / 'topics.py').read_text()
    assert topics
    assert all(f"'/{name}/image_raw'" in publishers for name in topics)


def test_one_driver_at_most_can_be_launched() -> None:
    (driver,) = (a for a in actions_of('robot') if a.args and a.args[0] == 'driver')
    assert driver.named['choices'] == ['none', 'planner', 'lamps']
    given = [dict(group.args[0][0].named['launch_arguments']) for group in load('robot').parts()]
    wanted = [one['drive'].args[1] for one in given if 'drive' in one]
    assert sorted(wanted) == ['lamps', 'planner']
    assert all(configurations_in(one['drive']) == {'driver'} for one in given if 'drive' in one)
