"""Build of the ament_python package shirube_bringup; its facts are in setup.cfg."""

from setuptools import setup

setup()
