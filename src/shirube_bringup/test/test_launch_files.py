"""ROS's launch system is not on PyPI, so the launch files are read here, not run."""

import ast
from pathlib import Path

import pytest
import yaml

PACKAGE = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize(
    ('launch', 'config'),
    [
        ('arbiter', 'pose_arbiter'),
        ('floor', 'floor_localizer'),
        ('planner', 'reward_planner'),
        ('stereo', 'stereo_landmark'),
        ('vlc', 'vlc_beacon'),
    ],
)
def test_launch_file_starts_the_node_that_the_parameter_file_is_for(launch: str, config: str) -> None:
    tree = ast.parse((PACKAGE / 'launch' / f'{launch}.launch.py').read_text())
    node = next(c for c in ast.walk(tree) if isinstance(c, ast.Call) and getattr(c.func, 'id', '') == 'Node')
    named = {k.arg: k.value.value for k in node.keywords if isinstance(k.value, ast.Constant)}
    parameters = yaml.safe_load((PACKAGE / 'config' / f'{config}.yaml').read_text())
    assert named['package'] in (PACKAGE / 'package.xml').read_text()
    assert list(parameters) == [named['name']]
    assert list(parameters[named['name']]) == ['ros__parameters']
