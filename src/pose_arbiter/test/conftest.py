"""Shared fixtures: an isolated ROS graph, and the path of the test modules."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from node_testing import IsolatedGraph, isolated_graph

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def graph() -> Iterator[IsolatedGraph]:
    """An isolated ROS graph."""
    with isolated_graph() as opened:
        yield opened
