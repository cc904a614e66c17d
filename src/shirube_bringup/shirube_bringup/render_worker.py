"""Renders the sensor images in a separate process, in parallel to the nodes."""

import math
from collections.abc import Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from time import process_time
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from scene_simulator.mission.pedestrians import Place
from scene_simulator.mission.sensors import MissionSensors
from shirube_core.geometry import SE2
from shirube_core.waveform import Waveform

Picture = NDArray[Any]
_sensors: list[MissionSensors] = []  # sensors of the worker process (at most one element)


@dataclass(frozen=True)
class PiecewisePath:
    """The true motion in an exposure: rising times, (n,) [s], and ``T_map_base`` at them."""

    times: tuple[float, ...]
    poses: tuple[SE2, ...]

    def pose_at(self, time: float) -> SE2:
        """Return the pose at a time [s], interpolated; constant beyond both ends."""
        after = min(max(1, int(np.searchsorted(self.times, time))), len(self.times) - 1)
        start, stop = self.times[after - 1], self.times[after]
        fraction = min(max((time - start) / (stop - start), 0.0), 1.0)
        here, there = self.poses[after - 1], self.poses[after]
        yaw_change = math.remainder(there.yaw - here.yaw, math.tau)
        x, y = here.x + fraction * (there.x - here.x), here.y + fraction * (there.y - here.y)
        return SE2(x, y, here.yaw + fraction * yaw_change)


class RenderWorker:
    """Renders requested images in a worker process; use it in a `with` statement."""

    def __init__(self, seed: int, waveforms: dict[int, Waveform]) -> None:
        """Start the process for the room of a seed, with the waveform of each lamp by its ID."""
        self._pool = ProcessPoolExecutor(
            1, get_context('spawn'), initializer=initialize_worker, initargs=(seed, waveforms)
        )
        self._pending: dict[tuple[str, int], Future[Sequence[Picture]]] = {}

    def __enter__(self) -> Self:
        """Render one image of each sensor, which compiles the numba kernels."""
        self._pool.submit(compile_render_kernels).result()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the process."""
        self._pool.shutdown(wait=True, cancel_futures=True)

    def request(self, sensor: str, index: int, time: float, path: PiecewisePath, people: Sequence[Place] = ()) -> None:
        """Request the image of a sensor at a time [s]; the path covers its exposure, people are at these places."""
        self._pending[sensor, index] = self._pool.submit(_render, sensor, index, time, path, people)

    def collect(self, sensor: str, index: int) -> Sequence[Picture]:
        """Wait for a requested image and return it: one image, or the left and the right one."""
        return self._pending.pop((sensor, index)).result()

    def cpu_time(self) -> float:
        """Return the CPU time of the process [s], after it has rendered all requests."""
        return self._pool.submit(process_time).result()


def initialize_worker(seed: int, waveforms: dict[int, Waveform]) -> None:
    """Prepare this process for rendering the sensors of a seed, with the waveform of each lamp by its ID."""
    _sensors[:] = [MissionSensors(seed, waveforms)]


def compile_render_kernels() -> None:
    """Render one image of each sensor in this process, which compiles the numba kernels."""
    start, people = _sensors[0].layout.start, [(1.0, 1.0)]
    still = PiecewisePath((0.0, 1.0), (start, start))
    for sensor in ('floor', 'ceiling', 'stereo', 'depth'):
        _render(sensor, 0, 0.5, still, people)


def _render(
    sensor: str, index: int, time: float, path: PiecewisePath, people: Sequence[Place] = ()
) -> Sequence[Picture]:
    sensors = _sensors[0]
    match sensor:
        case 'floor':
            return (sensors.floor_picture(index, time, path.pose_at),)
        case 'ceiling':
            return (sensors.ceiling_picture(index, time, path.pose_at, people),)
        case 'stereo':
            return sensors.stereo_pair(index, time, path.pose_at, people)
        case _:
            return (sensors.depth_picture(index, time, path.pose_at, people),)
