"""Fixtures: an isolated ROS graph, and the import path of the test helpers."""

import sys
from pathlib import Path

from node_testing import graph

__all__ = ['graph']
sys.path.insert(0, str(Path(__file__).parent))
