"""Helper modules of this folder become importable; fixtures are an isolated ROS graph and the files of the wall."""

import sys
from pathlib import Path

import pytest
from node_testing import graph

__all__ = ['graph']
sys.path.insert(0, str(Path(__file__).parent))

from taught_wall import Files, write_files


@pytest.fixture(scope='session')
def shared_files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    """Files of the wall that tests only read."""
    return write_files(tmp_path_factory.mktemp('wall'))


@pytest.fixture
def files(tmp_path: Path) -> Files:
    """Files of the wall that a test may change."""
    return write_files(tmp_path)
