"""The robot's description agrees with the robot of the mission."""

import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from motor_bridge.core.diff_drive_kinematics import DriveSettings
from motor_bridge.node_settings import NodeSettings
from scene_simulator.mission.layout import BELLY_MOUNT, CEILING_MOUNT, ROBOT_HEIGHT, ROBOT_RADIUS
from scene_simulator.mission.sensors import DEPTH_MOUNT, STEREO_RIG
from shirube_core.geometry import CameraMount

ROBOT = ET.parse(Path(__file__).parents[1] / 'urdf' / 'demo_robot.urdf.xacro').getroot()
XACRO = '{http://www.ros.org/wiki/xacro}'
MOUNTS = {
    'floor': BELLY_MOUNT,
    'ceiling': CEILING_MOUNT,
    'left': STEREO_RIG.mount,
    'right': CameraMount(STEREO_RIG.right_xyz, STEREO_RIG.right_rpy),
    'depth': DEPTH_MOUNT,
}


def numbers(text: str) -> list[float]:
    """Return numbers of which some are ${...} of pi."""
    values = {'pi': math.pi, '-pi': -math.pi, 'pi / 2': math.pi / 2.0, '-pi / 2': -math.pi / 2.0}
    return [values[inner] if inner else float(plain) for inner, plain in re.findall(r'\$\{(.+?)\}|(\S+)', text)]


def test_every_camera_is_where_the_mission_has_it() -> None:
    cameras = {each.attrib['name']: each.attrib for each in ROBOT.findall(f'{XACRO}camera')}
    assert set(cameras) == set(MOUNTS)
    for name, mount in MOUNTS.items():
        np.testing.assert_allclose(numbers(cameras[name]['xyz']), mount.xyz, atol=1e-12)
        np.testing.assert_allclose(numbers(cameras[name]['rpy']), mount.rpy, atol=1e-12)
        parent = cameras[name].get('parent', 'base_link')
        assert parent == ('left_camera_optical_frame' if name == 'right' else 'base_link')


def test_body_and_wheels_are_those_of_the_mission() -> None:
    sizes = {each.attrib['name']: float(each.attrib['value']) for each in ROBOT.findall(f'{XACRO}property')}
    drive, bridge = DriveSettings(), NodeSettings()
    assert (sizes['radius'], sizes['height']) == (ROBOT_RADIUS, ROBOT_HEIGHT)
    assert sizes['wheel_radius'] == pytest.approx(drive.wheel_radius)
    assert sizes['wheel_separation'] == pytest.approx(drive.wheel_separation)
    joints = {f'{each.attrib["name"]}_wheel_joint' for each in ROBOT.findall(f'{XACRO}wheel')}
    assert joints == {bridge.left_wheel_joint, bridge.right_wheel_joint}
