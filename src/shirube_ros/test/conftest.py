"""A ROS graph for each test that wants one."""

from collections.abc import Iterator

import pytest
from node_testing import IsolatedGraph, isolated_graph


@pytest.fixture
def graph() -> Iterator[IsolatedGraph]:
    """Nodes that see only each other."""
    with isolated_graph() as opened:
        yield opened
