"""What the drive costs: how long a simulated second takes, and how long each process works."""

from __future__ import annotations

from time import monotonic, process_time

from shirube_mission.node_processes import NodeProcesses
from shirube_mission.render_worker import RenderWorker


class Stopwatch:
    """Runs during the drive.

    Attributes:
        pace: simulated time and the time since the start [s], about once a simulated second.
        cpu: processor time of each process [s], once it was stopped.
    """

    def __init__(self, processes: NodeProcesses, worker: RenderWorker) -> None:
        """Prepare.

        Args:
            processes: the nodes.
            worker: renders the pictures.
        """
        self.pace: list[tuple[float, float]] = []
        self.cpu: dict[str, float] = {}
        self._processes, self._worker = processes, worker
        self._began, self._worked = monotonic(), dict[str, float]()

    def start(self) -> None:
        """Begin to count."""
        self._began, self._worked = monotonic(), self._working_times()

    def look(self, now: float) -> None:
        """Take the mission's time [s]."""
        if not self.pace or now >= self.pace[-1][0] + 1.0:
            self.pace.append((now, monotonic() - self._began))

    def stop(self) -> None:
        """Take what all have worked since the start."""
        self.cpu = {name: time - self._worked[name] for name, time in self._working_times().items()}

    def _working_times(self) -> dict[str, float]:
        others = {'pictures': self._worker.processor_time(), 'simulation': process_time()}
        return {**self._processes.processor_times(), **others}
