"""Makes the helper modules of this folder importable; provides an isolated ROS graph as a fixture."""

from __future__ import annotations

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
