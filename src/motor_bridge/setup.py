"""Build of the ament_python package motor_bridge; its facts are in setup.cfg."""

from setuptools import setup

setup()
