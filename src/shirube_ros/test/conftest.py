"""A ROS graph for each test that wants one."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from shirube_ros.isolated_graph import IsolatedGraph, isolated_graph


@pytest.fixture
def graph() -> Iterator[IsolatedGraph]:
    """Nodes that see only each other."""
    with isolated_graph() as opened:
        yield opened
