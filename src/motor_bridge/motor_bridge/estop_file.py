"""Keeps the emergency stop over a restart of the node: a file that exists while it is active."""

import math
import os
from pathlib import Path

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from shirube_core.files import atomic_write


class EmergencyStop:
    """Stops from a true until a false, and without messages.

    Attributes:
        is_latched: whether the last message was true.
    """

    def __init__(self, heartbeat: float, *, is_latched: bool) -> None:
        """Start, perhaps still stopped from before a restart; a ``heartbeat`` [s] of 0 is none."""
        self._heartbeat, self.is_latched = heartbeat, is_latched
        self._last_time: float | None = None

    def take(self, now: float, *, is_on: bool) -> None:
        """Take a message, received at a time [s]."""
        self.is_latched, self._last_time = is_on, now

    def reason(self, now: float) -> str:
        """Return why the robot must not drive at a time [s]; empty if it may."""
        if self.is_latched and self._last_time is None:
            return 'stopped by estop before the restart; publish false on estop to release it'
        if self.is_latched:
            return 'stopped by estop'
        age = math.inf if self._last_time is None else now - self._last_time
        if self._heartbeat > 0.0 and not 0.0 <= age <= self._heartbeat:
            return f'stopped, no message on estop for {self._heartbeat:g} s (estop_heartbeat); check its publisher'
        return ''


def estop_file(state_dir: str, node_name: str) -> Path:
    """Return the path of a node's file, by default below ``ROS_HOME``."""
    folder = state_dir or f'{os.environ.get("ROS_HOME") or "~/.ros"}/shirube'
    return Path(os.path.expanduser(folder)) / f'{node_name.strip("/").replace("/", ".")}.estop'  # noqa: PTH111 no error


def is_stop_kept(path: Path) -> bool:
    """Return whether the emergency stop was active; a file that cannot be checked counts as active."""
    try:
        path.lstat()
    except OSError as fault:
        return not isinstance(fault, (FileNotFoundError, NotADirectoryError))
    return True


def keep_stop(path: Path, *, is_on: bool) -> None:
    """Create or delete the file; it is on the disk afterwards, so that a power failure does not lose it.

    Raises:
        MotorBridgeError: a read-only or full disk.
    """
    try:
        if is_on:
            with atomic_write(path) as file:
                file.write(b'The emergency stop is active; publish false on estop to release it.\n')
                file.flush()
                os.fsync(file.fileno())
        else:
            path.unlink(missing_ok=True)
    except OSError as fault:
        what = 'active, but not kept over' if is_on else 'released, but only until'
        raise MotorBridgeError(
            f'estop is {what} a restart: {path}: {fault.strerror}; set state_dir to a writable folder'
        ) from fault
