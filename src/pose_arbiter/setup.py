"""Build of the ament_python package pose_arbiter; its facts are in setup.cfg."""

from setuptools import setup

setup()
