"""A ROS graph for each test that wants one."""

from node_testing import graph

__all__ = ['graph']
