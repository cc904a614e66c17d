"""A node that cannot start or ends is reported with its log; all nodes end with the block."""

from __future__ import annotations

import time

import pytest

from shirube_bringup.nodes import MissionError, NodeProcesses, NodeSetup


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
