"""Makes the helper modules of this folder importable and marks the tests that run on both dependency sets."""

import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
ON_BOTH_SETS = ('test_bag_commands.py', 'test_commands.py', 'test_mission_sensors.py', 'test_stereo_camera.py')
"""Bags and pictures of each camera are made there; no robot needs more of the simulator."""


def pytest_collection_modifyitems(items: Sequence[pytest.Item]) -> None:
    """Mark the others."""
    for item in items:
        if item.path.parent == HERE and item.path.name not in ON_BOTH_SETS:
            item.add_marker('newest_set_only')
