"""Base class of the nodes: a lifecycle node that by default configures and activates itself."""

import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, TypeVar, cast

from rcl_interfaces.msg import SetParametersResult
from rclpy._rclpy_pybind11 import RCLError
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.subscription import Subscription

from shirube_core.settings import SettingsError, setting
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.diagnostics import Diagnostics, Level, Status
from shirube_ros.input_watch import InputWatch, Need
from shirube_ros.parameters import (
    change_settings,
    changed_parameters,
    declare_parameters,
    parameters_of,
    reject_misspelled_parameters,
)
from shirube_ros.quality_of_service import overridable

Settings = TypeVar('Settings')

_ROBOT_FRAMES = ('base_frame', 'odom_frame', 'camera_frame')  # map_frame is that of all robots
_ENTITIES = ('subscription', 'publisher', 'timer', 'service', 'client', 'waitable')


@dataclass(frozen=True)
class LifecycleSettings:
    """Parameters of every managed node."""

    autostart: bool = setting(
        True, 'whether the node configures and activates itself; otherwise a lifecycle manager does'
    )
    frame_prefix: str = setting(
        '', 'prefix of base_frame, odom_frame and camera_frame, such as robot1/, as in robot_state_publisher'
    )


class ManagedNode(LifecycleNode):
    """A lifecycle node with typed settings, a callback guard, an input watch and diagnostics.

    The constructor declares and checks the parameters. `configure` loads files and creates publishers, subscriptions,
    services and timers; an inactive node drops its input and publishes nothing but diagnostics; `halt` stops the robot.
    Cleaning up destroys what `configure` created. A subclass calls `start` at the end of its constructor.

    Attributes:
        SETTINGS: settings classes that are declared as parameters.
        COMMON_SETTINGS: the same for every node.
        ERRORS: errors of the package for invalid messages and files.
    """

    COMMON_SETTINGS: ClassVar[tuple[type, ...]] = (LifecycleSettings,)
    SETTINGS: ClassVar[tuple[type, ...]] = ()
    ERRORS: ClassVar[tuple[type[Exception], ...]] = ()

    def __init__(self, name: str, **options: Any) -> None:
        """Declare the parameters; options are those of ``rclpy.node.Node``.

        Raises:
            SettingsError: an invalid parameter.
        """
        super().__init__(name, **options)
        with self._destroyed_on_error():
            self._survive_invalid_transitions()
            self._settings_by_class: dict[type, object] = {}
            self._fault: Exception | None = None
            self._is_starting = False
            self._user_errors: tuple[type[Exception], ...] = (SettingsError, OSError, *self.ERRORS)
            self.declare(LifecycleSettings)
            self.declare_settings()
            reject_misspelled_parameters(self)
            self.check_settings()
            self._guard = CallbackGuard(self, self.ERRORS)
            self._guard.is_active = False
            self._inputs = InputWatch(self, self._guard.counts)
            self._diagnostics = Diagnostics(self, self._guard.counts, self._current_status, self._inputs)
            self._permanent_entities = {kind: set(getattr(self, f'{kind}s')) for kind in _ENTITIES}
            self._permanent_names: set[str] = set()

    # What a node implements.

    def declare_settings(self) -> None:
        """Declare the parameters."""
        for cls in self.SETTINGS:
            self.declare(cls)

    def check_settings(self) -> None:
        """Raise an error for settings that contradict each other."""

    def configure(self) -> None:
        """Load files and create publishers, subscriptions, services and timers."""

    def activate(self) -> None:
        """Start what `halt` ends."""

    def halt(self) -> None:
        """Stop the robot; called when the node is deactivated, and before it ends."""

    def apply_settings(self) -> None:
        """Use changed settings from the next message on; an error must leave the former ones in use."""

    def status(self) -> Status:
        """Return the status of the active node."""
        return Status(Level.OK, 'active')

    # What a node uses.

    def declare(self, cls: type[Settings]) -> Settings:
        """Declare the settings of a class as parameters, and keep them up to date; errors as `declare_parameters`."""
        settings = declare_parameters(self, cls, allow_tuning=True)
        self._settings_by_class[cls] = settings
        return self.settings(cls)

    def settings(self, cls: type[Settings]) -> Settings:
        """Return the current settings of a class; the robot's frames have the prefix."""
        settings: Any = self._settings_by_class[cls]
        prefix = cast('LifecycleSettings', self._settings_by_class[LifecycleSettings]).frame_prefix
        names = [each.name for each in fields(settings) if prefix and each.name in _ROBOT_FRAMES]
        frames = {name: prefix + getattr(settings, name) for name in names if getattr(settings, name)}
        return cast('Settings', replace(settings, **frames))

    def subscribe(
        self,
        kind: type,
        topic: str,
        callback: Callable[[Any], None],
        profile: Any,
        need: Need | None = None,
        *,
        name: str = '',
        while_inactive: bool = False,
    ) -> Subscription:
        """Create a guarded subscription whose QoS can be overridden, and watch it if a need is given.

        The name is that of the input in counts and messages, by default the topic. An inactive node drops messages,
        except with ``while_inactive``.
        """
        guarded = self._guard.guard(name or topic, callback, while_inactive=while_inactive)
        if need is not None:
            self._inputs.add(topic, need, name=name)
        return self.create_subscription(kind, topic, guarded, profile, qos_overriding_options=overridable())

    def create_guarded_timer(self, period: float, name: str, callback: Callable[[], None]) -> None:
        """Create a timer with a period [s] that does nothing while the node is inactive; errors are caught."""
        guarded = self._guard.guard(name, lambda _: callback())
        self.create_timer(period, lambda: guarded(None))

    def start(self) -> None:
        """Configure and activate, with ``autostart``; errors are those of `configure`."""
        if not self.settings(LifecycleSettings).autostart:
            self.get_logger().info('unconfigured; waiting for a lifecycle manager (autostart is false)')
            return
        self._is_starting = True
        with self._destroyed_on_error():
            for trigger in (self.trigger_configure, self.trigger_activate):
                if trigger() is not TransitionCallbackReturn.SUCCESS and self._fault:
                    raise self._fault
        self._is_starting = False

    def stop(self) -> None:
        """Stop the robot before the node ends."""
        if self._guard.is_active:
            self.halt()

    @property
    def lifecycle_state(self) -> str:
        """Label of the state: unconfigured, inactive, active, finalized."""
        return str(self._state_machine.current_state[1])

    # The transitions, called by rclpy.

    def on_configure(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Configure; a failure leaves the node unconfigured."""
        self._permanent_names = {*vars(self)}
        outcome = self._attempt(self.configure)
        if outcome is not TransitionCallbackReturn.SUCCESS:
            self._release()
        return outcome

    def on_activate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Let callbacks and outputs work."""
        outcome = self._attempt(self.activate)
        if outcome is TransitionCallbackReturn.SUCCESS:
            self._inputs.start()
            self._guard.is_active = True
        return outcome

    def on_deactivate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Stop the robot; callbacks and outputs rest."""
        self._guard.is_active = self._inputs.is_active = False
        return self._attempt(self.halt)

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Release what `configure` created."""
        return self._attempt(self._release)

    def on_shutdown(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Stop the robot and release what `configure` created."""
        self.stop()
        self._guard.is_active = False
        return self._attempt(self._release)

    def on_error(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Release everything after an internal error; the node is unconfigured then."""
        self._guard.is_active = False
        self._release()
        return TransitionCallbackReturn.SUCCESS

    @contextmanager
    def _destroyed_on_error(self) -> Iterator[None]:
        """Destroy a node that cannot start; left to the garbage collector, it can block the process at any time."""
        try:
            yield
        except BaseException:
            super().destroy_node()
            raise

    def _survive_invalid_transitions(self) -> None:
        """Refuse a transition that the state does not have; rclpy would end the node."""
        change_state = self._service_change_state.callback

        def respond(request: Any, response: Any) -> Any:
            try:
                return change_state(request, response)
            except RCLError:
                return response  # without success

        self._service_change_state.callback = respond

    def _attempt(self, step: Callable[[], None]) -> TransitionCallbackReturn:
        """Run a step of a transition; its error is logged, but with ``autostart`` raised by `start`."""
        try:
            step()
        except self._user_errors as fault:
            self._fault, outcome = fault, TransitionCallbackReturn.FAILURE
            words = ' '.join(str(fault).split())
        except Exception as fault:  # noqa: BLE001 a bug must not end a managed node
            self._fault, outcome = fault, TransitionCallbackReturn.ERROR
            words = f'internal error:\n{traceback.format_exc()}'
        else:
            return TransitionCallbackReturn.SUCCESS
        if not self._is_starting:
            self.get_logger().error(words)
        return outcome

    def _release(self) -> None:
        """Destroy the entities and drop the attributes that `configure` created."""
        for kind, permanent in self._permanent_entities.items():
            for entity in {*getattr(self, f'{kind}s')} - permanent:
                destroy = getattr(self, f'destroy_{kind}', type(entity).destroy)  # waitables: action servers
                destroy(entity)
        self._inputs.clear()
        for name in vars(self).keys() - self._permanent_names:
            delattr(self, name)

    def _current_status(self) -> Status:
        state = self.lifecycle_state
        if not self._guard.is_active:
            return Status(Level.WARN, f'{state}; activate the node', {'lifecycle': state})
        status = self.status()
        return replace(status, values={'lifecycle': state, **status.values})

    # Parameters that change at run time; rclpy's parameter services call this.

    def set_parameters(self, parameter_list: Sequence[Parameter]) -> list[SetParametersResult]:
        """Set parameters one by one; see `set_parameters_atomically`."""
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: Sequence[Parameter]) -> SetParametersResult:
        """Check values as at the start and apply them together, or refuse all with a reason."""
        before = self._settings_by_class
        parameter_list = changed_parameters(self, parameter_list)
        try:
            changes = change_settings(self, before, parameter_list)
            self._use(before | changes)
        except self._user_errors as fault:
            return SetParametersResult(successful=False, reason=' '.join(str(fault).split()))
        result = super().set_parameters_atomically(parameters_of(changes, parameter_list))
        if not result.successful:
            self._use(before)
        return result

    def _use(self, settings: dict[type, object]) -> None:
        before, self._settings_by_class = self._settings_by_class, settings
        if settings == before:
            return
        try:
            self.check_settings()
            if self.lifecycle_state in ('inactive', 'active'):
                self.apply_settings()
        except Exception:
            self._settings_by_class = before
            raise
