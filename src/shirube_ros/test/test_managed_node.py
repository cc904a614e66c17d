"""Lifecycle and tunable parameters of a managed node, as a manager and `ros2 param set` see them."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from node_testing import IsolatedGraph
from rcl_interfaces.srv import SetParametersAtomically
from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.parameter import Parameter
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from shirube_core.settings import SettingsError, setting, tunable
from shirube_ros.callback_guard import create_trigger_service
from shirube_ros.diagnostics import Level, Status
from shirube_ros.managed_node import ManagedNode
from shirube_ros.quality_of_service import pose_profile

TRANSITIONS = {
    'configure': Transition.TRANSITION_CONFIGURE,
    'activate': Transition.TRANSITION_ACTIVATE,
    'deactivate': Transition.TRANSITION_DEACTIVATE,
    'cleanup': Transition.TRANSITION_CLEANUP,
}


@tunable()
@dataclass(frozen=True)
class Limits:
    least: float = setting(0.0, 'least factor', limits=(0.0, 10.0))
    most: float = setting(5.0, 'greatest factor', limits=(0.0, 10.0))


@tunable('factor')
@dataclass(frozen=True)
class ScalerSettings:
    factor: float = setting(2.0, 'factor', limits=(0.0, 10.0))
    file: str = setting('', 'file that must exist')
    weights: tuple[float, ...] = setting((), 'weights')
    limits: Limits = field(default_factory=Limits)


class Scaler(ManagedNode):
    """Publishes what it receives, scaled."""

    SETTINGS = (ScalerSettings,)

    def __init__(self, **options: Any) -> None:
        super().__init__('scaler', **options)
        self.halts = 0
        self.start()

    def check_settings(self) -> None:
        limits = self.settings(ScalerSettings).limits
        if limits.least > limits.most:
            raise SettingsError('least is greater than most; exchange them')

    def configure(self) -> None:
        self.apply_settings()
        self.output = self.create_publisher(Float64, '~/out', pose_profile())
        if self.settings(ScalerSettings).file:
            Path(self.settings(ScalerSettings).file).read_text()
        self.subscribe(Float64, 'in', self._scale, pose_profile())
        self.create_guarded_timer(0.02, 'tick', lambda: self.output.publish(Float64(data=-1.0)))
        create_trigger_service(self, self._guard, '~/serve', lambda: 'served')

    def apply_settings(self) -> None:
        self._factor = self.settings(ScalerSettings).factor

    def halt(self) -> None:
        self.halts += 1

    def status(self) -> Status:
        return Status(Level.OK, 'scaling')

    def _scale(self, message: Float64) -> None:
        self.output.publish(Float64(data=self._factor * message.data))


class Manager:
    """The node and a manager that calls its services and sends it messages."""

    def __init__(self, graph: IsolatedGraph, **parameters: object) -> None:
        self._graph = graph
        self.node = graph.add(Scaler, **parameters)
        self._client = graph.node('manager')
        self._input = self._client.create_publisher(Float64, 'in', 10)
        self.received: list[float] = []
        self._client.create_subscription(Float64, '/scaler/out', lambda message: self.received.append(message.data), 10)

    def call(self, kind: type, name: str, request: Any) -> Any:
        client = self._client.create_client(kind, f'/scaler/{name}')
        assert self._graph.spin_until(client.service_is_ready)
        future = client.call_async(request)
        assert self._graph.spin_until(future.done)
        return future.result()

    def change(self, name: str) -> bool:
        request = ChangeState.Request(transition=Transition(id=TRANSITIONS[name]))
        return bool(self.call(ChangeState, 'change_state', request).success)

    def set(self, **values: object) -> str:
        """Set parameters together, with a dot for each double underscore; return the reason of a refusal."""
        parameters = [Parameter(n.replace('__', '.'), value=v).to_parameter_msg() for n, v in values.items()]
        request = SetParametersAtomically.Request(parameters=parameters)
        result = self.call(SetParametersAtomically, 'set_parameters_atomically', request).result
        return '' if result.successful else str(result.reason)

    def scaled(self, number: float) -> float | None:
        """Return what the node publishes for a number, None if nothing."""
        assert self._graph.spin_until(lambda: self._input.get_subscription_count() == 1)
        self.received.clear()
        self._input.publish(Float64(data=number))
        self._graph.spin_until(lambda: any(value >= 0.0 for value in self.received), 0.5)
        return next((value for value in self.received if value >= 0.0), None)


@pytest.mark.parametrize('parameters', [{'factor': -1.0}, {'file': 'missing'}])
def test_a_node_that_cannot_start_is_destroyed_at_once(graph: IsolatedGraph, parameters: dict[str, object]) -> None:
    # Destroyed later, by the garbage collector, it once blocked a process for good.
    nodes: list[Scaler] = []

    class Failing(Scaler):
        def declare_settings(self) -> None:
            nodes.append(self)
            super().declare_settings()

    with pytest.raises((SettingsError, OSError)):
        graph.add(Failing, **parameters)
    with pytest.raises(InvalidHandle), nodes[0].handle:
        pass


def test_a_manager_takes_the_node_through_its_states_and_back(graph: IsolatedGraph) -> None:
    manager = Manager(graph, autostart=False)
    node = manager.node
    before = [len([*entities]) for entities in (node.subscriptions, node.publishers, node.timers, node.services)]
    for _ in range(2):
        assert node.lifecycle_state == 'unconfigured'
        assert manager.change('configure')
        assert manager.scaled(3.0) is None
        assert manager.received == []
        assert not manager.call(Trigger, 'serve', Trigger.Request()).success
        assert manager.change('activate')
        assert manager.scaled(3.0) == 6.0
        assert manager.call(Trigger, 'serve', Trigger.Request()).success
        halts = node.halts
        assert manager.change('deactivate')
        assert node.halts == halts + 1
        node.stop()  # as at the end of the process
        assert node.halts == halts + 1
        manager.scaled(3.0)
        assert manager.received == []
        assert manager.change('cleanup')
        after = (node.subscriptions, node.publishers, node.timers, node.services)
        assert [len([*entities]) for entities in after] == before
        assert not hasattr(node, 'output')
    assert not manager.change('activate')
    assert node.lifecycle_state == 'unconfigured'


def test_a_failing_configuration_is_one_line_and_can_be_repeated(
    graph: IsolatedGraph, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / 'map.csv'
    with pytest.raises(FileNotFoundError):
        graph.add(Scaler, file=str(file))
    assert capfd.readouterr().err == ''
    manager = Manager(graph, autostart=False, file=str(file))
    assert not manager.change('configure')
    assert manager.node.lifecycle_state == 'unconfigured'
    lines = [line for line in capfd.readouterr().err.splitlines() if str(file) in line]
    assert len(lines) == 1
    assert '[ERROR]' in lines[0]
    file.write_text('')
    assert manager.change('configure')
    assert manager.change('activate')
    assert manager.scaled(1.0) == 2.0


def test_diagnostics_show_the_state(graph: IsolatedGraph) -> None:
    manager = Manager(graph)
    status = manager.node._current_status()
    assert (status.level, status.message, status.values) == (Level.OK, 'scaling', {'lifecycle': 'active'})
    manager.change('deactivate')
    status = manager.node._current_status()
    assert (status.level, status.values) == (Level.WARN, {'lifecycle': 'inactive'})


def test_a_tunable_parameter_holds_from_the_next_message_on_and_is_checked_as_at_the_start(
    graph: IsolatedGraph,
) -> None:
    manager = Manager(graph)
    assert manager.set(factor=3) == ''  # a whole number is as good as at the start
    assert manager.scaled(2.0) == 6.0
    assert manager.node.get_parameter('factor').value == 3.0
    with pytest.raises(SettingsError) as refusal:
        graph.add(Scaler, factor=11.0)
    for values, reason in (
        ({'factor': 11.0}, str(refusal.value)),
        ({'factor': 'wide'}, "setting factor is 'wide', it must be a number"),
        ({'factor': 4.0, 'limits__least': -1.0}, 'setting limits.least is -1.0, allowed is 0 to 10'),
        ({'factor': 4.0, 'limits__least': 6.0}, 'least is greater than most; exchange them'),
        ({'factor': 4.0, 'file': 'x.csv'}, 'file can only be set at start: restart the node with file:=x.csv'),
        ({'factr': 4.0}, 'parameter factr does not exist, did you mean factor?'),
        ({'nonsense': 4.0}, 'parameter nonsense does not exist in this node'),
        ({'factor': 4.0, 'file': None}, 'file can only be set at start'),  # ros2 param delete
        ({'factor': 4.0, 'weights': [2.0]}, 'weights can only be set at start'),
        ({'factor': 4.0, 'autostart': 1}, 'autostart can only be set at start'),
        ({'factor': 4.0, 'use_sim_time': 1.0}, 'Wrong parameter type'),  # rclpy's own,
    ):
        assert reason in manager.set(**values)
        assert manager.scaled(2.0) == 6.0, values
        assert manager.node.get_parameter('factor').value == 3.0
        assert manager.node.settings(ScalerSettings) == ScalerSettings(3.0)
    assert manager.set(factor=4.0, limits__least=6.0, limits__most=7.0) == ''
    assert manager.node.settings(ScalerSettings) == ScalerSettings(4.0, limits=Limits(6.0, 7.0))


@pytest.mark.parametrize('weights', [[], [1.0, 2.0]])
def test_what_ros2_param_dump_wrote_can_be_loaded(graph: IsolatedGraph, weights: list[float]) -> None:
    manager = Manager(graph, weights=weights)
    dumped = {name: each.value for name, each in manager.node._parameters.items()}
    assert manager.set(factor=5.0) == ''
    assert manager.set(**dumped) == ''
    assert manager.node.settings(ScalerSettings).factor == 2.0
    assert manager.set(**{name: value for name, value in dumped.items() if name != 'factor'}) == ''
