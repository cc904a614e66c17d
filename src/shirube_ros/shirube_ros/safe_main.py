"""The main function of every node: a clean start, a clean end."""

from __future__ import annotations

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
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.node import Node
from rclpy.qos_overriding_options import InvalidQosOverridesError
from rclpy.signals import SignalHandlerOptions

from shirube_ros.node_executor import node_executor
from shirube_settings import SettingsError

# What a user can get wrong on the command line, in a parameter file or in the files that parameters name.
_START_ERRORS = (
    SettingsError,
    OSError,
    RCLError,
    ParameterException,
    NameValidationException,
    InvalidQosOverridesError,
)
_END_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_LONGEST_WAIT = 0.5  # a signal whose waking call was lost is seen after this time [s]


@runtime_checkable
class StoppableNode(Protocol):
    """A node with last words, such as a velocity of zero."""

    def stop(self) -> None:
        """Say them; called once, whatever ends the node, while its publishers still work."""


def run_node(
    name: str, create_node: Callable[[], Node], start_errors: tuple[type[Exception], ...] = ()
) -> int:
    """Run a node until it is told to end; a `StoppableNode` is stopped then.

    Args:
        name: the node's name, for the error line.
        create_node: makes the node; called after rclpy is up.
        start_errors: errors of the node's own package that the user can mend.

    Returns:
        the exit code: 0 after SIGINT or SIGTERM, 1 after a start error, of which one line went to stderr.
    """
    with _EndSignals() as signals:
        try:
            # rclpy's own handlers would shut the context down before the node can say its last words.
            rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        except RCLError as error:
            return _refuse(name, error)
        try:
            _spin(create_node(), signals)
        except (*_START_ERRORS, *start_errors) as error:
            if not signals.received:
                return _refuse(name, error)
        except KeyboardInterrupt:
            pass
        except Exception:
            # Compiled code turns the interrupt of a start into an error of its own.
            if not signals.received:
                raise
        finally:
            rclpy.try_shutdown()
    return 0


class _EndSignals:
    """Turns a signal during the start into a KeyboardInterrupt, which ends long work at once, and notes all others.

    Once the node works, signals only count: they end the loop after the callback that runs. An interrupt within it
    could strike in compiled code, which cannot bear it; and a second Ctrl-C must not spoil the ending.
    """

    def __init__(self) -> None:
        self.received = 0
        self.may_interrupt = True

    def __enter__(self) -> Self:
        for number in _END_SIGNALS:
            signal.signal(number, self._handle)
        return self

    def __exit__(self, *_: object) -> None:
        for number in _END_SIGNALS:
            signal.signal(number, signal.SIG_IGN)

    def _handle(self, _number: int, _frame: FrameType | None) -> None:
        self.received += 1
        if self.may_interrupt:
            self.may_interrupt = False
            raise KeyboardInterrupt


@contextmanager
def _woken_by_signals(executor: Executor) -> Iterator[None]:
    """Let a signal end the executor's wait, after which Python calls the handler."""
    heard, told = socket.socketpair()
    told.setblocking(False)

    def wake() -> None:
        while heard.recv(1):
            executor.wake()

    waker = Thread(target=wake, daemon=True)
    waker.start()
    signal.set_wakeup_fd(told.fileno(), warn_on_full_buffer=False)
    try:
        yield
    finally:
        signal.set_wakeup_fd(-1)
        told.close()
        waker.join()
        heard.close()


def _spin(node: Node, signals: _EndSignals) -> None:
    signals.may_interrupt = False
    try:
        executor = node_executor()
        executor.add_node(node)
        with _woken_by_signals(executor):
            while not signals.received and rclpy.ok():
                executor.spin_once(timeout_sec=_LONGEST_WAIT)
    except ExternalShutdownException:
        pass
    except (RCLError, InvalidHandle):
        if rclpy.ok():
            raise  # else the context was taken away in the middle of a call
    except RuntimeError:
        if not signals.received:
            raise  # else a signal struck while rclpy took a message, which turns the interrupt into this
    finally:
        try:
            if isinstance(node, StoppableNode) and rclpy.ok():
                node.stop()
        finally:
            node.destroy_node()


def _refuse(name: str, error: Exception) -> int:
    one_line = ' '.join(str(error).split())
    print(f'{name}: {one_line}', file=sys.stderr)  # noqa: T201 the one line that the user is owed
    return 1
