"""Parameters of a real node from a settings class."""

from dataclasses import dataclass, field
from typing import Any

import pytest
from node_testing import IsolatedGraph
from rclpy.node import Node
from rclpy.parameter import Parameter

from shirube_core.settings import SettingsError, check_settings, setting
from shirube_ros.camera.settings import CameraSettings
from shirube_ros.parameters import declare_parameters, reject_misspelled_parameters


@dataclass(frozen=True)
class Dots:
    diameter: float = setting(0.002, 'dot kept', 'm', (0.0, 0.1), former_name='width')
    count: int = setting(5, 'fewest dots', limits=(3, None))


@dataclass(frozen=True)
class Floor:
    dots: Dots = field(default_factory=Dots)
    enabled: bool = setting(True, 'whether it works')
    method: str = setting('pole', 'which way', choices=('pole', 'pair'))
    xyz: tuple[float, float, float] = setting((0.0, 0.0, 0.1), 'where it sits', 'm', (-1.0, None))
    weights: tuple[float, ...] = setting((1.0,), 'weights')


def settings_of(graph: IsolatedGraph, **overrides: Any) -> tuple[Node, Floor]:
    node = graph.add(lambda **options: Node('floor', **options), **overrides)
    return node, declare_parameters(node, Floor)


def test_without_overrides_the_defaults_hold(graph: IsolatedGraph) -> None:
    node, settings = settings_of(graph)
    assert settings == Floor()
    assert node.get_parameter('dots.diameter').value == 0.002
    assert list(node.get_parameter('xyz').value) == [0.0, 0.0, 0.1]


def test_overrides_arrive_also_as_whole_numbers(graph: IsolatedGraph) -> None:
    overrides = {'dots.diameter': 0, 'dots.count': 9, 'enabled': False, 'method': 'pair', 'xyz': [1, 0, 2]}
    node, settings = settings_of(graph, **overrides)
    assert settings == Floor(Dots(0.0, 9), False, 'pair', (1.0, 0.0, 2.0))
    assert node.get_parameter('dots.diameter').type_ is Parameter.Type.DOUBLE
    assert node.get_parameter('xyz').type_ is Parameter.Type.DOUBLE_ARRAY


def test_parameters_are_described_limited_and_read_only(graph: IsolatedGraph) -> None:
    node, _ = settings_of(graph)
    diameter = node.describe_parameter('dots.diameter')
    assert (diameter.description, diameter.read_only) == ('dot kept [m]', True)
    assert diameter.floating_point_range[0].to_value == 0.1
    assert node.describe_parameter('dots.count').integer_range[0].from_value == 3
    assert node.describe_parameter('method').additional_constraints == "'pole' or 'pair'"
    assert node.describe_parameter('xyz').additional_constraints == '-1 m or more'
    assert not node.set_parameters([Parameter('dots.diameter', value=0.01)])[0].successful


@pytest.mark.parametrize(
    ('overrides', 'words'),
    [
        ({'dots.diameter': 2.0}, r'dots\.diameter is 2.0 m, allowed is 0 to 0.1 m'),
        # Of another type than the parameter is declared with:
        ({'dots.diameter': 'wide'}, r"dots\.diameter is 'wide', it must be a number"),
        ({'dots.count': 3.5}, r'dots\.count is 3.5, it must be a whole number'),
        ({'enabled': 'perhaps'}, r"enabled is 'perhaps', it must be true or false"),
        ({'xyz': ['a', 'b', 'c']}, r'it must be 3 numbers'),
    ],
)
def test_bad_values_are_refused(graph: IsolatedGraph, overrides: dict[str, Any], words: str) -> None:
    with pytest.raises(SettingsError, match=words):
        settings_of(graph, **overrides)


def test_the_default_camera_looks_down_and_is_allowed() -> None:
    check_settings(CameraSettings())
    assert CameraSettings().mount.rotation[:, 2] == pytest.approx([0.0, 0.0, -1.0])


def test_nearly_the_name_of_a_parameter_is_refused(graph: IsolatedGraph) -> None:
    node, _ = settings_of(graph, **{'dots.diametr': 0.001})
    with pytest.raises(SettingsError, match=r'dots\.diametr does not exist, did you mean dots\.diameter'):
        reject_misspelled_parameters(node)


def test_a_former_name_is_rejected_with_the_new_one(graph: IsolatedGraph) -> None:
    with pytest.raises(SettingsError, match=r'^parameter dots.width is now called dots.diameter; .*migrate'):
        settings_of(graph, **{'dots.width': 0.01})


def test_a_parameter_of_another_node_is_only_warned_of(graph: IsolatedGraph, capfd: pytest.CaptureFixture[str]) -> None:
    node, _ = settings_of(graph, wheel_radius=0.1)
    reject_misspelled_parameters(node)
    assert 'wheel_radius does not exist in this node' in capfd.readouterr().err
