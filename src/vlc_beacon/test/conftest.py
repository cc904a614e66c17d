"""Makes helper modules importable, and provides an isolated ROS graph as a fixture."""

from __future__ import annotations

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


@pytest.fixture
def beacons_file(tmp_path: Path) -> Path:
    """The two lamps that the node under test knows."""
    path = tmp_path / 'beacons.yaml'
    path.write_text(
        'beacons: [{id: 1, xyz: [0.0, 0.0, 2.5], radius: 0.03}, {id: 2, xyz: [1.0, 0.0, 2.5], radius: 0.03}]'
    )
    return path
