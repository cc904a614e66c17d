"""Build of the ament_python package reward_planner; its facts are in setup.cfg."""

from setuptools import setup

setup()
