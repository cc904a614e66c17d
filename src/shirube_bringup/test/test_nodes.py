"""Each node's command line names its parameter file; a node that ends is reported with its log."""

import time
from pathlib import Path

import pytest
import yaml

from shirube_bringup.building import BuildingFiles
from shirube_bringup.nodes import MissionError, NodeProcesses, NodeSetup, mission_nodes


def test_the_six_nodes_get_their_files_and_topics(tmp_path):
    files = BuildingFiles(Path('/building'))
    nodes = {node.package: node for node in mission_nodes(files, '/dev/pts/9')}
    assert len(nodes) == 6
    values = {}
    for name, node in nodes.items():
        flag, params, path, *remapped = node.arguments(tmp_path)
        assert (flag, params) == ('--ros-args', '--params-file')
        assert remapped[::2] == ['-r'] * len(node.topics)
        values[name] = yaml.safe_load(Path(path).read_text())[name]['ros__parameters']
        assert values[name]['use_sim_time'] is True
    assert values['motor_bridge']['port'] == '/dev/pts/9'
    assert values['floor_localizer']['map_file'] == '/building/floor.dotmap'
    assert values['reward_planner']['drive'] is True
    assert nodes['reward_planner'].topics['pose'] == '/pose_arbiter/pose'


def test_pictures_do_not_get_lost(tmp_path):
    for node in mission_nodes(BuildingFiles(Path('/building')), 'x'):
        text = Path(node.arguments(tmp_path)[2]).read_text()
        assert text.count('reliability: reliable') == len(node.images)


def test_the_papers_planner_is_a_choice():
    files = BuildingFiles(Path('/building'))
    planner = {node.package: node for node in mission_nodes(files, 'x', 'paper')}['reward_planner']
    assert (planner.parameters['mode'], planner.parameters['rule']) == ('reward', 'count')


def check_until_it_ends(nodes: NodeProcesses) -> None:
    """Look as the mission does."""
    while True:
        nodes.check()
        time.sleep(0.05)


def test_a_node_that_ends_is_named_with_its_log(tmp_path):
    nodes = NodeProcesses([NodeSetup('no_such_package', {}, {})], tmp_path, 77)
    message = 'no_such_package ended with exit code 1; see '
    with nodes, pytest.raises(MissionError, match=message):
        check_until_it_ends(nodes)
    assert nodes.exit_codes == {'no_such_package': 1}
    assert 'No module named' in (tmp_path / 'no_such_package.log').read_text()


@pytest.mark.newest_set_only
def test_a_bad_parameter_shows_as_the_nodes_own_line(tmp_path):
    setup = NodeSetup('motor_bridge', {'wheel_radius': -1.0}, {})
    nodes = NodeProcesses([setup], tmp_path, 77)
    with nodes, pytest.raises(MissionError, match='motor_bridge ended with exit code 1'):
        check_until_it_ends(nodes)
    assert 'wheel_radius' in (tmp_path / 'motor_bridge.log').read_text()


def test_a_node_that_has_ended_is_seen_and_works_no_more(tmp_path):
    nodes = NodeProcesses([NodeSetup('no_such_package', {}, {})], tmp_path, 77)
    with nodes:
        while not nodes.has_ended():
            time.sleep(0.05)
        assert nodes.cpu_times() == {}
