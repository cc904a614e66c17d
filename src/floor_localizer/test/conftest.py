"""Shared fixtures: an isolated ROS graph, and one floor for all tests."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from node_testing import IsolatedGraph, isolated_graph

from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.localizer import FloorLocalizer

sys.path.insert(0, str(Path(__file__).parent))  # for the helper modules of the tests

from floor_views import MOUNT, random_floor


@pytest.fixture
def graph() -> Iterator[IsolatedGraph]:
    """Nodes that see only each other."""
    with isolated_graph() as opened:
        yield opened


@pytest.fixture(scope='session')
def floor() -> DotMap:
    """A floor of about three thousand dots, as dense as the paper's."""
    return random_floor(1)


@pytest.fixture(scope='session')
def indexed_floor(floor: DotMap) -> IndexedMap:
    """The same floor with its search index."""
    return index_map(floor)


@pytest.fixture(scope='session')
def localizer(indexed_floor: IndexedMap) -> FloorLocalizer:
    """A localizer on that floor."""
    return FloorLocalizer(indexed_floor, MOUNT)
