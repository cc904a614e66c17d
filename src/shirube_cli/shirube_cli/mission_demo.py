"""The mission: all nodes drive a simulated robot through a room of unknown obstacles to three goals."""

import sys
from pathlib import Path

from shirube_cli.child_process import child_process
from shirube_cli.workspace import find_executable, overlay_environment


def demo_mission(root: Path, folder: Path) -> int:
    """Run the mission and leave its report, its numbers and the nodes' logs in the folder.

    Returns:
        0 when every goal was reached well and nothing was touched, 1 otherwise.

    Raises:
        CommandError: the mission's package is not installed.
    """
    command = [sys.executable, str(find_executable(root, 'shirube_bringup', 'room')), str(folder)]
    with child_process(command, overlay_environment(root), log=None) as process:
        code = process.wait()
    return 1 if code else 0
