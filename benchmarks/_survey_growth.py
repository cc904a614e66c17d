"""Memory and time of a survey by floor size: dots are simulated, so nothing is rendered or detected."""

from __future__ import annotations

import json
import multiprocessing
import threading
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

import numpy as np
from _surveyed_floor import CAMERA, MOUNT, VIEW, RenderedSurvey
from scipy.spatial import cKDTree

from floor_localizer.commands.options import task_runner
from floor_localizer.core.dots import DetectedDots
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.submap import select_keyframes
from floor_localizer.survey_files.checkpoint import Checkpoint
from floor_localizer.survey_files.survey_run import IMAGES_PER_CHUNK, build_all_submaps, run_survey

_NOISE = 0.02
"""Standard deviation of the position of a dot along each axis [px]."""
_EVERY = 0.01  # period of memory sampling [s]


@dataclass(frozen=True)
class Growth:
    """Time and memory of the pose graph and the adjustment.

    Attributes:
        images: number of images on the map.
        observations: number of observations of dots.
        base: private memory before: the interpreter and its libraries [bytes].
        peak: peak private memory of the main process [bytes].
        worker_peak: peak private memory of a worker, 0 without one [bytes].
        seconds: time of pose graph and adjustment [s].
        error: rms position error of the images after rigid alignment [m].
    """

    images: int
    observations: int
    base: int
    peak: int
    worker_peak: int
    seconds: float
    error: float


def measure_growth(size: float, seed: int, settings: SurveySettings, workers: int) -> Growth:
    """Survey a simulated floor, pose graph and adjustment in a new process; submaps are kept for the next run."""
    folder = Path(f'out/bench_survey/growth_{size}_{seed}')
    spawn = multiprocessing.get_context('spawn')
    for step in (_prepare, _match_and_adjust):
        process = spawn.Process(target=step, args=(folder, size, seed, settings, workers))
        process.start()
        process.join()
        if process.exitcode:
            raise SystemExit(process.exitcode)
    return Growth(**json.loads((folder / 'growth.json').read_text()))


def _prepare(folder: Path, size: float, seed: int, settings: SurveySettings, workers: int) -> None:
    """Simulate the dots of the images and build submaps."""
    survey, checkpoint = RenderedSurvey(size, seed), Checkpoint(folder, {'size': size, 'seed': seed})
    floor = survey.floor
    tree = cKDTree(floor.points)
    chosen = select_keyframes([frame.T_odom_base for frame in survey.frames], VIEW, settings)
    for chunk, start in enumerate(range(0, len(chosen), IMAGES_PER_CHUNK)):
        if checkpoint.load_dots(chunk) is not None:
            continue
        found: dict[int, DetectedDots | str] = {
            index: _observe(survey, tree, floor.points, floor.diameters, index, seed)
            for index in chosen[start : start + IMAGES_PER_CHUNK]
        }
        checkpoint.save_dots(chunk, found)
    with task_runner(workers) as runner:
        build_all_submaps(survey, MOUNT, settings, checkpoint, runner)


def _observe(
    survey: RenderedSurvey, tree: cKDTree, points: np.ndarray, diameters: np.ndarray, index: int, seed: int
) -> DetectedDots:
    """Return the simulated dots of an image of the drive."""
    pose, rng = survey.truth[index], np.random.default_rng([seed, 2, index])
    near = np.sort(np.array(tree.query_ball_point((pose.x, pose.y), VIEW), dtype=np.int64))
    at = MOUNT.camera_points_from_floor(pose.inverse().transform(points[near]))
    pixels = CAMERA.pixels_from_points(at) + rng.normal(0.0, _NOISE, (len(near), 2))
    whole = ((pixels > 3.0) & (pixels < CAMERA.width - 4.0)).all(axis=1)
    size = diameters[near[whole]] * CAMERA.fx / MOUNT.xyz[2]
    return DetectedDots(pixels[whole], size, np.full(len(size), _NOISE))


def _match_and_adjust(folder: Path, size: float, seed: int, settings: SurveySettings, workers: int) -> None:
    """Build the pose graph, adjust, and write the measurements."""
    for step in (*folder.glob('linked.npz'), *folder.glob('adjusted_*.npz')):
        step.unlink()
    survey, checkpoint = RenderedSurvey(size, seed), Checkpoint(folder, {'size': size, 'seed': seed})
    with task_runner(workers) as runner, _PrivateMemory() as memory:
        base, start = private_memory(), time.perf_counter()
        run = run_survey(survey, MOUNT, settings, checkpoint, runner)
        seconds = time.perf_counter() - start
    names = [int(run.images.frames[k].name.split()[1]) for k in run.result.images]
    truth = np.array([complex(survey.truth[k].x, survey.truth[k].y) for k in names])
    found = run.result.states[:, :2] @ (1.0, 1j)
    z, m = found - found.mean(), truth - truth.mean()
    turn = np.vdot(z, m)
    error = float(np.sqrt(np.mean(np.abs(turn / abs(turn) * z - m) ** 2)))
    observations = int(run.result.counts.sum())
    grown = Growth(len(names), observations, base, memory.peak, memory.worker_peak, seconds, error)
    (folder / 'growth.json').write_text(json.dumps(asdict(grown)))


def private_memory(process: int | str = 'self') -> int:
    """Return the private memory of a process; files in the page cache do not count [bytes]."""
    lines = Path(f'/proc/{process}/status').read_text().splitlines()
    return 1024 * next((int(line.split()[1]) for line in lines if line.startswith('RssAnon')), 0)


def _children() -> list[int]:
    """Return the child processes of this process."""
    return [
        int(child)
        for path in Path('/proc/self/task').glob('*/children')
        for child in path.read_text().split()
    ]


class _PrivateMemory:
    """Samples the memory of this process and of its workers in a thread."""

    def __init__(self) -> None:
        self.peak = self.worker_peak = 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()

    def _watch(self) -> None:
        workers = _children()
        while not self._ended.wait(_EVERY):
            self.peak = max(self.peak, private_memory())
            self.worker_peak = max(self.worker_peak, *map(private_memory, workers), 0)
