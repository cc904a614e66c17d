"""Where the repository is, and how its tools are started."""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path


class CommandError(RuntimeError):
    """A request that cannot be fulfilled; the message is one line that names the remedy."""


def find_root() -> Path:
    """Return the repository that contains this package; raise a CommandError if it was installed somewhere
    else.
    """
    root = Path(__file__).resolve().parents[3]
    if not (root / 'ros2_ws').is_dir():
        raise CommandError('works inside a clone of the repository only; call ./shirube there')
    return root


def safe_environment() -> dict[str, str]:
    """Return the environment for children.

    DDS stays on this machine unless the caller chose otherwise, and a character that the terminal's encoding lacks
    is printed as a question mark.
    """
    encoding, _, errors = os.environ.get('PYTHONIOENCODING', '').partition(':')
    return {
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        **os.environ,
        'PYTHONIOENCODING': f'{encoding}:{errors or "replace"}',
    }


def run_tool(module: str, arguments: Sequence[str]) -> int:
    """Run a Python tool of the environment (such as ``pytest``) at the root and return its exit code."""
    command = [sys.executable, '-m', module, *arguments]
    return subprocess.run(command, cwd=find_root(), env=safe_environment(), check=False).returncode
