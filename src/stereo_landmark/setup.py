"""Build of the ament_python package stereo_landmark; its facts are in setup.cfg."""

from setuptools import setup

setup()
