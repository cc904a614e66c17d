"""Keeps the emergency stop over a restart of the node: a file that exists while it is active."""

from __future__ import annotations

import os
from pathlib import Path

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from shirube_core.files import atomic_write

_NOT_KEPT = 'estop is not kept over a restart'
_REMEDY = 'set state_dir to a writable folder'


class EstopFile:
    """File of one node.

    Attributes:
        path: path of the file.
    """

    def __init__(self, state_dir: str, node_name: str) -> None:
        """Choose the path, by default below ``ROS_HOME``.

        Raises:
            MotorBridgeError: there is no home folder.
        """
        folder = state_dir or f'{os.environ.get("ROS_HOME") or "~/.ros"}/shirube'
        try:
            self.path = Path(folder).expanduser() / f'{node_name.strip("/").replace("/", ".")}.estop'
        except RuntimeError as fault:
            raise MotorBridgeError(f'{folder}: there is no home folder; set state_dir or ROS_HOME') from fault

    def is_on(self) -> bool:
        """Return whether the emergency stop was active; a file that cannot be checked counts as active."""
        try:
            self.path.lstat()
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:
            return True
        return True

    def check_writable(self) -> None:
        """Raise a MotorBridgeError if the file could not be written now."""
        folder = next(each for each in self.path.parents if os.path.lexists(each))
        if not folder.is_dir() or not os.access(folder, os.W_OK | os.X_OK):
            raise MotorBridgeError(f'{_NOT_KEPT}: {self.path} is not writable; {_REMEDY}')

    def store(self, *, is_on: bool) -> None:
        """Create or delete the file; it is on the disk afterwards, so that a power failure does not lose it.

        Raises:
            MotorBridgeError: a read-only or full disk.
        """
        try:
            if is_on:
                with atomic_write(self.path) as file:
                    file.write(b'The emergency stop is active; publish false on estop to release it.\n')
                    file.flush()
                    os.fsync(file.fileno())
            else:
                self.path.unlink(missing_ok=True)
        except OSError as fault:
            what = _NOT_KEPT if is_on else 'estop is released, but only until a restart'
            raise MotorBridgeError(f'{what}: {self.path}: {fault.strerror}; {_REMEDY}') from fault
