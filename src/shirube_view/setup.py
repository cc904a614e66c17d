"""Build of the ament_python package shirube_view; its facts are in setup.cfg."""

from setuptools import setup

setup()
