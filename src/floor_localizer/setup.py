"""Build of the ament_python package floor_localizer; its facts are in setup.cfg."""

from setuptools import setup

setup()
