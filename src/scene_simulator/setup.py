"""Build of the ament_python package scene_simulator; its facts are in setup.cfg."""

from setuptools import setup

setup()
