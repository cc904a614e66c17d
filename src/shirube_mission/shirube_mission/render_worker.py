"""Renders what the sensors see in a process of its own, while the nodes work."""

from __future__ import annotations

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

from light_waveform import Waveform
from scene_simulator.mission_sensors import MissionSensors
from shirube_geometry import PlanarPose

Picture = NDArray[Any]

_sensors: list[MissionSensors] = []
"""Of the worker's process, which has one room only."""


@dataclass(frozen=True)
class PiecewisePath:
    """The true motion during an exposure.

    Attributes:
        times: shape (n,), rising [s].
        poses: ``T_map_base`` at these times.
    """

    times: tuple[float, ...]
    poses: tuple[PlanarPose, ...]

    def pose_at(self, time: float) -> PlanarPose:
        """Return the pose at a time [s], even between two, and as at the end beyond them."""
        after = min(max(1, int(np.searchsorted(self.times, time))), len(self.times) - 1)
        start, stop = self.times[after - 1], self.times[after]
        share = min(max((time - start) / (stop - start), 0.0), 1.0)
        here, there = self.poses[after - 1], self.poses[after]
        turn = math.remainder(there.yaw - here.yaw, math.tau)
        x, y = here.x + share * (there.x - here.x), here.y + share * (there.y - here.y)
        return PlanarPose(x, y, here.yaw + share * turn)


class RenderWorker:
    """Takes orders for pictures and gives them when they are asked for; to be used in a `with` statement."""

    def __init__(self, seed: int, waveforms: dict[int, Waveform]) -> None:
        """Start the process.

        Args:
            seed: of the room.
            waveforms: what each lamp plays, by its ID.
        """
        self._pool = ProcessPoolExecutor(
            1, get_context('spawn'), initializer=_begin, initargs=(seed, waveforms)
        )
        self._waiting: dict[tuple[str, int], Future[Sequence[Picture]]] = {}

    def __enter__(self) -> Self:
        """Render one picture of each kind, which compiles what must be compiled."""
        self._pool.submit(_warm_up).result()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the process."""
        self._pool.shutdown(wait=True, cancel_futures=True)

    def order(self, sensor: str, index: int, time: float, path: PiecewisePath) -> None:
        """Order what a sensor sees at a time [s]; the path covers its exposure."""
        self._waiting[sensor, index] = self._pool.submit(_render, sensor, index, time, path)

    def take(self, sensor: str, index: int) -> Sequence[Picture]:
        """Return what was ordered, waiting for it: one picture, or the left and the right one."""
        return self._waiting.pop((sensor, index)).result()

    def processor_time(self) -> float:
        """Return how long the process has worked [s], once it has rendered all that was ordered."""
        return self._pool.submit(process_time).result()


def render_one_of_each(seed: int, waveforms: dict[int, Waveform]) -> None:
    """Render a picture of each sensor here, which compiles what must be compiled.

    Args:
        seed: of the room.
        waveforms: what each lamp plays, by its ID.
    """
    _begin(seed, waveforms)
    _warm_up()


def _begin(seed: int, waveforms: dict[int, Waveform]) -> None:
    _sensors[:] = [MissionSensors(seed, waveforms)]


def _warm_up() -> None:
    start = _sensors[0].layout.start
    still = PiecewisePath((0.0, 1.0), (start, start))
    for sensor in ('floor', 'ceiling', 'stereo', 'depth'):
        _render(sensor, 0, 0.5, still)


def _render(sensor: str, index: int, time: float, path: PiecewisePath) -> Sequence[Picture]:
    sensors = _sensors[0]
    match sensor:
        case 'floor':
            return (sensors.floor_picture(index, time, path.pose_at),)
        case 'ceiling':
            return (sensors.ceiling_picture(index, time, path.pose_at),)
        case 'stereo':
            return sensors.stereo_pair(index, time, path.pose_at)
        case _:
            return (sensors.depth_picture(index, time, path.pose_at),)
