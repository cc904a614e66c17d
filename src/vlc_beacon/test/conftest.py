"""Makes helper modules importable, and provides an isolated ROS graph as a fixture."""

import sys
from pathlib import Path

from node_testing import graph

__all__ = ['graph']
sys.path.insert(0, str(Path(__file__).parent))
