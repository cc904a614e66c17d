"""Each node's command line names its parameter file; a node that ends is reported with its log."""

import time
from pathlib import Path

import pytest
import yaml

from shirube_bringup.building import BuildingFiles
from shirube_bringup.nodes import MissionError, NodeProcesses, NodeSetup, mission_nodes


def test_the_nodes_get_their_files_and_topics(tmp_path):
    files = BuildingFiles(Path('/building'))
    nodes = {node.package: node for node in mission_nodes(files, '/dev/pts/9')}
    assert len(nodes) == 7
    values = {}
    for name, node in nodes.items():
        flag, params, path, *remapped = node.arguments(tmp_path)
        assert (flag, params) == ('--ros-args', '--params-file')
        assert remapped[::2] == ['-r'] * len(node.topics)
        values[name] = yaml.safe_load(Path(path).read_text())['/**']['ros__parameters']
        assert values[name]['use_sim_time'] is True
    assert values['motor_bridge']['port'] == '/dev/pts/9'
    assert values['floor_localizer']['map_file'] == '/building/floor.dotmap'
    assert values['reward_planner']['drive'] is True
    assert nodes['reward_planner'].topics['pose'] == 'pose_arbiter/pose'
    # Nobody but the monitor commands the base.
    assert nodes['reward_planner'].topics['cmd_vel'] == 'cmd_vel_in'
    assert 'cmd_vel' not in nodes['collision_monitor'].topics


def test_pictures_do_not_get_lost(tmp_path):
    for node in mission_nodes(BuildingFiles(Path('/building')), 'x'):
        text = Path(node.arguments(tmp_path)[2]).read_text()
        assert text.count('reliability: reliable') == len(node.images)


def test_the_papers_planner_is_a_choice():
    files = BuildingFiles(Path('/building'))
    planner = {node.package: node for node in mission_nodes(files, 'x', 'paper')}['reward_planner']
    assert (planner.parameters['mode'], planner.parameters['rule']) == ('reward', 'count')


@pytest.mark.parametrize(
    ('package', 'parameters', 'line'),
    [
        ('no_such_package', {}, 'No module named'),
        pytest.param('motor_bridge', {'wheel_radius': -1.0}, 'wheel_radius', marks=pytest.mark.newest_set_only),
    ],
)
def test_a_node_that_ends_is_named_with_its_log_and_works_no_more(tmp_path, package, parameters, line):
    with NodeProcesses([NodeSetup(package, parameters, {})], tmp_path, 77) as nodes:
        while not nodes.has_ended():
            time.sleep(0.05)
        with pytest.raises(MissionError, match=f'{package} ended with exit code 1; see '):
            nodes.check()
        assert nodes.cpu_times() == {}
    assert nodes.exit_codes == {package: 1}
    assert line in (tmp_path / f'{package}.log').read_text()
