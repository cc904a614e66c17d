"""Fixtures: an isolated ROS graph, and the import path of the test helpers."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from node_testing import IsolatedGraph, graph

__all__ = ['graph']
sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def robot(graph: IsolatedGraph, tmp_path: Path) -> Iterator[Any]:
    """The node with an emulated robot and a driver."""
    from emulated_robot import Robot  # noqa: PLC0415 a helper in this folder

    with Robot(graph, tmp_path / 'tty') as made:
        yield made
