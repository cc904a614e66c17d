"""Processes of the mission's nodes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from shirube_bringup.mission_error import MissionError
from shirube_bringup.node_parameters import NodeSetup

_SHUTDOWN_TIMEOUT = 10.0
"""Timeout after SIGINT [s]."""


class NodeProcesses:
    """Runs the nodes inside of a `with` statement and ends them with SIGINT.

    Attributes:
        exit_codes: exit codes of the ended nodes, by name.
    """

    def __init__(self, nodes: Sequence[NodeSetup], folder: Path, domain: int) -> None:
        """Set the nodes to run.

        Args:
            nodes: nodes to start.
            folder: folder for parameter files and logs.
            domain: ROS domain of the mission.
        """
        self._nodes, self._folder, self._domain = nodes, folder, domain
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self.exit_codes: dict[str, int] = {}

    def __enter__(self) -> Self:
        """Start all nodes at once."""
        environment = {
            **os.environ,
            'ROS_DOMAIN_ID': str(self._domain),
            'ROS_LOG_DIR': str(self._folder / 'log'),
            # Seven processes on two cores: more threads would only compete.
            'OMP_NUM_THREADS': '1',
            'OPENBLAS_NUM_THREADS': '1',
        }
        for node in self._nodes:
            command = [sys.executable, '-m', f'{node.package}.node', *node.arguments(self._folder)]
            with (self._folder / f'{node.package}.log').open('wb') as log:
                self._running[node.package] = subprocess.Popen(
                    command,
                    env=environment,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End all nodes with SIGINT, then with SIGKILL after a timeout."""
        for process in self._running.values():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for name, process in self._running.items():
            try:
                self.exit_codes[name] = process.wait(_SHUTDOWN_TIMEOUT)
            except subprocess.TimeoutExpired:
                process.kill()
                self.exit_codes[name] = process.wait()

    def cpu_times(self) -> dict[str, float]:
        """Return the CPU time of each running node [s], by name."""
        times = {}
        for name, process in self._running.items():
            if process.poll() is not None:
                continue
            fields = Path(f'/proc/{process.pid}/stat').read_text().rpartition(')')[2].split()
            times[name] = (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
        return times

    def has_ended(self) -> bool:
        """Return whether a node has ended unexpectedly."""
        return any(process.poll() is not None for process in self._running.values())

    def check(self) -> None:
        """Raise if a node has ended.

        Raises:
            MissionError: a node has ended; the message names its log.
        """
        for name, process in self._running.items():
            if process.poll() is not None:
                log = self._folder / f'{name}.log'
                raise MissionError(f'{name} ended with exit code {process.returncode}; see {log}')
