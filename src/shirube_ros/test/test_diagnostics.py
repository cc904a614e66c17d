"""Messages on /diagnostics."""

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from node_testing import IsolatedGraph
from rclpy.node import Node

from shirube_ros.callback_guard import TopicCount
from shirube_ros.diagnostics import Diagnostics, Level, Status


class Reports:
    """A publishing node and a subscribing node."""

    def __init__(self, graph: IsolatedGraph, status: Status, **parameters: object) -> None:
        self.counts = {'image_raw': TopicCount(received=3)}
        self.received: list[DiagnosticStatus] = []
        talker = graph.add(lambda **options: Node('talker', **options), **parameters)
        self.diagnostics = Diagnostics(talker, self.counts, lambda: status)
        listener = graph.node('listener')
        listener.create_subscription(
            DiagnosticArray, '/diagnostics', lambda array: self.received.extend(array.status), 10
        )
        self._graph = graph

    def next(self) -> DiagnosticStatus:
        before = len(self.received)
        assert self._graph.spin_until(lambda: len(self.received) > before)
        return self.received[-1]


def test_reports_carry_status_values_and_counts(graph: IsolatedGraph) -> None:
    reports = Reports(graph, Status(Level.OK, 'fix', {'match rate': '0.97'}))
    report = reports.next()
    assert (report.name, report.level, report.message) == ('talker: status', DiagnosticStatus.OK, 'fix')
    assert {value.key: value.value for value in report.values} == {'match rate': '0.97', 'image_raw received': '3'}


@pytest.mark.parametrize(('level', 'with_refusal'), [(Level.OK, Level.WARN), (Level.ERROR, Level.ERROR)])
def test_a_refusal_is_at_least_a_warning_once_and_stays_counted(
    graph: IsolatedGraph, level: Level, with_refusal: Level
) -> None:
    reports = Reports(graph, Status(level, 'fix'))
    reports.counts['image_raw'].reject('too dark')
    report = reports.next()
    assert (Level(report.level), report.message) == (with_refusal, 'fix; too dark')
    report = reports.next()
    assert (Level(report.level), report.message) == (level, 'fix')
    assert ('image_raw rejected', '1: too dark') in [(value.key, value.value) for value in report.values]


def test_reports_continue_while_simulated_time_is_paused(graph: IsolatedGraph) -> None:
    reports = Reports(graph, Status(Level.OK, 'fix'), use_sim_time=True)
    reports.next()
    reports.next()
