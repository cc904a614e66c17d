"""Invalid parameters of the node are rejected in one line."""

import pytest
from node_testing import run_in_process

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.node import MotorBridgeNode, main
from shirube_core.settings import SettingsError

pytestmark = pytest.mark.newest_set_only


@pytest.mark.parametrize(
    ('parameters', 'words'),
    [
        ({'port': ''}, 'port is empty; set it to the serial port'),
        ({'base_frame': 'odom'}, 'odom_frame and base_frame are equal; give them different names'),
        ({'left_wheel_joint': 'right_wheel_joint'}, 'left_wheel_joint and right_wheel_joint are equal'),
        ({'wheel_radius': 0.0}, 'setting wheel_radius is 0.0 m, allowed is 0.005 to 1 m'),
        ({'wheel_separation': float('nan')}, 'setting wheel_separation is nan m, allowed is'),
        ({'wheel_radius': 0.4, 'ticks_per_revolution': 4}, 'frame, below the resolution of 1'),
        ({'wheel_radios': 0.03}, 'parameter wheel_radios does not exist, did you mean wheel_radius'),
    ],
)
def test_bad_parameters_are_refused_in_one_line(graph, parameters, words):
    with pytest.raises((SettingsError, MotorBridgeError), match=words) as refusal:
        graph.add(MotorBridgeNode, **parameters)
    assert '\n' not in str(refusal.value)


def test_a_bad_start_is_one_line_and_exit_code_1(capfd):
    assert run_in_process(main, '--ros-args', '-p', 'wheel_radius:=-1.0') == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith('motor_bridge: setting wheel_radius is -1.0 m')
