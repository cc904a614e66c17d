"""Build of the ament_python package vlc_beacon; its facts are in setup.cfg."""

from setuptools import setup

setup()
