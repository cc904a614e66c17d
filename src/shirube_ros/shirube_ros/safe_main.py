"""The main function of every node: a clean start, a clean end."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import rclpy
from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos_overriding_options import InvalidQosOverridesError

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


def run_node(
    name: str, create_node: Callable[[], Node], start_errors: tuple[type[Exception], ...] = ()
) -> int:
    """Run a node until it is told to end.

    Args:
        name: the node's name, for the error line.
        create_node: makes the node; called after rclpy is up.
        start_errors: errors of the node's own package that the user can mend.

    Returns:
        the exit code: 0 after SIGINT or SIGTERM, 1 after a start error, of which one line went to stderr.
    """
    with _signals_noted() as signals:
        try:
            rclpy.init()
        except RCLError as error:
            return _refuse(name, error)
        try:
            node = create_node()
            if not signals:
                _spin(node)
        except (*_START_ERRORS, *start_errors) as error:
            if not signals:
                return _refuse(name, error)
        finally:
            rclpy.try_shutdown()
    return 0


@contextmanager
def _signals_noted() -> Iterator[list[int]]:
    """Note signals instead of raising KeyboardInterrupt, which could strike in the middle of the ending.

    rclpy calls these handlers after its own, which shut the context down. Signals that come after the end
    of the node are ignored, so that a second Ctrl-C cannot spoil the exit code.
    """
    noted: list[int] = []
    for number in _END_SIGNALS:
        signal.signal(number, lambda received, _: noted.append(received))
    try:
        yield noted
    finally:
        for number in _END_SIGNALS:
            signal.signal(number, signal.SIG_IGN)


def _spin(node: Node) -> None:
    try:
        rclpy.spin(node)
    except ExternalShutdownException:
        pass
    except (RCLError, InvalidHandle):
        if rclpy.ok():
            raise  # else a signal took the context away in the middle of a call
    finally:
        node.destroy_node()


def _refuse(name: str, error: Exception) -> int:
    one_line = ' '.join(str(error).split())
    print(f'{name}: {one_line}', file=sys.stderr)  # noqa: T201 the one line that the user is owed
    return 1
