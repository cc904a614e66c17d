"""ROS's launch system is not on PyPI, so the launch file is read here, not run."""

import ast
from pathlib import Path

import yaml

PACKAGE = Path(__file__).resolve().parents[1]


def test_launch_file_starts_the_node_that_the_parameter_file_is_for() -> None:
    tree = ast.parse((PACKAGE / 'launch' / 'floor.launch.py').read_text())
    node = next(c for c in ast.walk(tree) if isinstance(c, ast.Call) and getattr(c.func, 'id', '') == 'Node')
    named = {k.arg: k.value.value for k in node.keywords if isinstance(k.value, ast.Constant)}
    parameters = yaml.safe_load((PACKAGE / 'config' / 'floor_localizer.yaml').read_text())
    assert named['package'] in (PACKAGE / 'package.xml').read_text()
    assert list(parameters) == [named['name']]
    assert list(parameters[named['name']]) == ['ros__parameters']
