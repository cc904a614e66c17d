"""The main function of every node: start errors in one line, clean shutdown on SIGINT and SIGTERM."""

import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread
from types import FrameType
from typing import Protocol, Self, runtime_checkable

import rclpy
from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos_overriding_options import InvalidQosOverridesError
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from shirube_core.read_only import ensure_log_folder
from shirube_core.settings import SettingsError
from shirube_ros.command_line import check_arguments, help_text, wants_help

try:
    from rclpy.experimental import EventsExecutor
except ImportError:  # before rclpy 7.1.5
    EventsExecutor = None


def node_executor(context: rclpy.Context | None = None) -> Executor:
    """Return an EventsExecutor, which calls callbacks one at a time in the order of their events.

    A SingleThreadedExecutor polls all entities of a node before each callback, which costs more than most callbacks: a
    node that receives a hundred small messages a second then needs two to three times the CPU time. Subscriptions whose
    callbacks take the MessageInfo must accept it and the message as one tuple: so rclpy's EventsExecutor passes them.
    """
    if EventsExecutor is None:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


# User errors on the command line, in a parameter file or in the files that parameters name.
_START_ERRORS = (
    SettingsError,
    OSError,
    RCLError,
    ParameterException,
    NameValidationException,
    InvalidQosOverridesError,
)
_TERMINATION_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_WAIT_MAX = 0.5  # longest delay of a signal whose wake-up was lost [s]


@runtime_checkable
class StoppableNode(Protocol):
    """A node with a final action, such as publishing a velocity of zero."""

    def stop(self) -> None:
        """Do the final action; called once before shutdown, while the publishers still work."""


def run_node(name: str, create_node: Callable[[], Node], start_errors: tuple[type[Exception], ...] = ()) -> int:
    """Run a node until a signal ends it; a `StoppableNode` is stopped then. ``--help`` prints help instead.

    Args:
        name: node name, for the error message.
        create_node: creates the node; called after rclpy.init.
        start_errors: errors of the node's package that the user can fix; a `ManagedNode` has them in ``ERRORS``.

    Returns:
        exit code: 0 after SIGINT or SIGTERM, 1 after a start error, which is printed to stderr as one line.
    """
    start_errors = (*_START_ERRORS, *start_errors, *getattr(create_node, 'ERRORS', ()))
    arguments = sys.argv[1:]
    if wants_help(name, arguments):
        print(help_text(name, create_node))  # noqa: T201 the user asked for it
        return 0
    try:
        for warning in check_arguments(name, arguments):
            _print_line(name, f'warning: {warning}')
    except SettingsError as error:
        return _print_error(name, error)
    ensure_log_folder()
    with _TerminationSignals() as signals:
        try:
            # rclpy's own handlers would shut the context down before the node's final action.
            rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        except RCLError as error:
            return _print_error(name, error)
        try:
            _spin(create_node(), signals)
        except start_errors as error:
            if not signals.received:
                return _print_error(name, error)
        except KeyboardInterrupt:
            pass
        except Exception:
            # Compiled code turns a KeyboardInterrupt during the start into another error.
            if not signals.received:
                raise
        finally:
            rclpy.try_shutdown()
    return 0


class _TerminationSignals:
    """Raises a KeyboardInterrupt for a signal during the start, and counts all signals.

    While the node spins, signals are only counted: they end the loop after the current callback. A KeyboardInterrupt
    could hit compiled code, which does not support it; and a second Ctrl-C must not interrupt the shutdown.
    """

    def __init__(self) -> None:
        self.received = 0
        self.is_starting = True

    def __enter__(self) -> Self:
        for number in _TERMINATION_SIGNALS:
            signal.signal(number, self._handle)
        return self

    def __exit__(self, *_: object) -> None:
        for number in _TERMINATION_SIGNALS:
            signal.signal(number, signal.SIG_IGN)

    def _handle(self, _number: int, _frame: FrameType | None) -> None:
        self.received += 1
        if self.is_starting:
            self.is_starting = False
            raise KeyboardInterrupt


@contextmanager
def _wake_on_signals(executor: Executor) -> Iterator[None]:
    """Wake the executor on a signal, after which Python calls the handler."""
    receiver, sender = socket.socketpair()
    sender.setblocking(False)

    def wake() -> None:
        while receiver.recv(1):
            executor.wake()

    thread = Thread(target=wake, daemon=True)
    thread.start()
    signal.set_wakeup_fd(sender.fileno(), warn_on_full_buffer=False)
    try:
        yield
    finally:
        signal.set_wakeup_fd(-1)
        sender.close()
        thread.join()
        receiver.close()


def _spin(node: Node, signals: _TerminationSignals) -> None:
    signals.is_starting = False
    try:
        executor = node_executor()
        executor.add_node(node)
        with _wake_on_signals(executor):
            while not signals.received and rclpy.ok():
                executor.spin_once(timeout_sec=_WAIT_MAX)
    except ExternalShutdownException:
        pass
    except (RCLError, InvalidHandle):
        if rclpy.ok():
            raise  # otherwise the context was shut down during a call
    except RuntimeError:
        if not signals.received:
            raise  # otherwise a signal interrupted rclpy while it took a message
    finally:
        try:
            if isinstance(node, StoppableNode) and rclpy.ok():
                node.stop()
        finally:
            node.destroy_node()


def drain_subscription(subscription: Subscription) -> None:
    """Pass all queued messages of a subscription to its callback; call it from a callback of its node.

    The executor takes one message of each topic in turn. A topic with a higher rate than the images, such as an IMU,
    falls behind while images are processed, although its messages have arrived.
    """
    while True:
        with subscription.handle:
            taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
        if taken is None:
            return
        subscription.callback(taken[0])


def _print_error(name: str, error: Exception) -> int:
    _print_line(name, ' '.join(str(error).split()))
    return 1


def _print_line(name: str, line: str) -> None:
    print(f'{name}: {line}', file=sys.stderr)  # noqa: T201 for the user, before there is a logger
