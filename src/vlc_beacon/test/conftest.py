"""Makes helper modules importable, and provides an isolated ROS graph as a fixture."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from node_testing import IsolatedGraph, isolated_graph

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def graph() -> Iterator[IsolatedGraph]:
    """Nodes that see only each other."""
    with isolated_graph() as opened:
        yield opened
