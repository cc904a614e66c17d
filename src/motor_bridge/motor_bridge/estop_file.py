"""Keeps the emergency stop over a restart of the node: a file that exists while it is active."""

import os
from pathlib import Path

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from shirube_core.files import atomic_write


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
