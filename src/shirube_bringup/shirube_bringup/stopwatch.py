"""Timing of the drive: wall time per simulated second, and CPU time of each process."""

from __future__ import annotations

from time import monotonic, process_time

from shirube_bringup.node_processes import NodeProcesses
from shirube_bringup.render_worker import RenderWorker


class Stopwatch:
    """Measures wall time and CPU times during the drive.

    Attributes:
        pace: simulated time and wall time since the start [s], about once per simulated second.
        cpu: CPU time of each process [s], after `stop`.
    """

    def __init__(self, processes: NodeProcesses, worker: RenderWorker) -> None:
        """Start without measurements.

        Args:
            processes: processes of the nodes.
            worker: process that renders the images.
        """
        self.pace: list[tuple[float, float]] = []
        self.cpu: dict[str, float] = {}
        self._processes, self._worker = processes, worker
        self._began, self._cpu_at_start = monotonic(), dict[str, float]()

    def start(self) -> None:
        """Start the measurement."""
        self._began, self._cpu_at_start = monotonic(), self._cpu_times()

    def record_time(self, now: float) -> None:
        """Record the wall time at a mission time [s]."""
        if not self.pace or now >= self.pace[-1][0] + 1.0:
            self.pace.append((now, monotonic() - self._began))

    def stop(self) -> None:
        """Compute the CPU times since the start."""
        self.cpu = {name: time - self._cpu_at_start[name] for name, time in self._cpu_times().items()}

    def _cpu_times(self) -> dict[str, float]:
        others = {'pictures': self._worker.cpu_time(), 'simulation': process_time()}
        return {**self._processes.cpu_times(), **others}
