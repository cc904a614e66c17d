"""Dots from simulated images against the truth: `./shirube bench dot_extraction`.

Prints a table of recall, precision, centroid error and time of the detector and of Source Extractor
(the package ``sep``, made for stars) where it is installed (``pip install sep``), for one condition after the
other. One core, CPU time, both detectors in turn on each image.
"""

from __future__ import annotations

import argparse
import math
import platform
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import cv2
import numpy as np
from _dot_conditions import CONDITIONS, Condition
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from tqdm import tqdm

from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DetectedDots
from scene_simulator.dot_floor import LIGHT_ON_DARK, generate_dot_floor
from scene_simulator.floor_camera import FloorCamera
from shirube_core.geometry import SE2, CameraMount

try:
    import sep
except ImportError:
    sep = None

Detect = Callable[[NDArray[np.uint8]], DetectedDots]

HEADS = (
    *('condition', 'recall', 'of touching chips', 'precision'),
    *('median error px', 'rms error px', 'rms error / sigma', 'ms'),
)

_SIZE = 1.2
_MARGIN = 0.3
_ISOLATED = 1.3
"""A dot is isolated when no other centre is nearer than this multiple of the mean of both diameters."""


@dataclass(frozen=True)
class TrueImage:
    """An image and its chips.

    Attributes:
        image: shape (h, w) or (h, w, 3).
        pixels: shape (n, 2), true centres of the chips with their centre in the image [px].
        diameters: shape (n,) [px].
        wanted: shape (n,), chips wholly in the image that no dirt hides.
        isolated: shape (n,), chips that touch no other.
    """

    image: NDArray[np.uint8]
    pixels: NDArray[np.float64]
    diameters: NDArray[np.float64]
    wanted: NDArray[np.bool_]
    isolated: NDArray[np.bool_]


def photographs(condition: Condition, seed: int) -> Iterator[TrueImage]:
    """Yield the images of a condition."""
    design = condition.design
    share = _SIZE**2 / (design.size[0] * design.size[1])
    design = replace(design, size=(_SIZE, _SIZE), count=round(share * design.count))
    floor = generate_dot_floor(design, seed)
    camera = FloorCamera(condition.camera, condition.lighting, condition.sensor, condition.colour)
    rng = np.random.default_rng(seed)
    pixel = CameraMount().xyz[2] / condition.camera.fx
    for _ in range(condition.images):
        x, y = rng.uniform(_MARGIN, _SIZE - _MARGIN, 2)
        heading, course = rng.uniform(-math.pi, math.pi, 2)
        way = np.linspace(-0.5, 0.5, round(4 * condition.blur) + 1) if condition.blur else np.zeros(1)
        way *= condition.blur * pixel
        poses = [SE2(x + s * math.cos(course), y + s * math.sin(course), heading) for s in way]
        disturbances = condition.disturbances(x, y) if condition.disturbances else ()
        photo = camera.photograph(floor, poses, disturbances=disturbances, rng=rng)
        chips, pixels = camera.visible_chips(floor, SE2(x, y, heading))
        diameters = floor.diameters[chips] / pixel
        margin = (0.5 * diameters + 1.5 + 0.5 * condition.blur)[:, None]
        size = np.array([condition.camera.width, condition.camera.height])
        inside = ((pixels > margin) & (pixels < size - 1 - margin)).all(axis=1)
        u, v = np.clip(np.rint(pixels).astype(int), 0, size - 1).T
        clean = cv2.blur(photo.dirt, (5, 5))[v, u] < 0.05
        image = _compressed(photo.image, condition.jpeg_quality) if condition.jpeg_quality else photo.image
        yield TrueImage(image, pixels, diameters, inside & clean, _isolated(pixels, diameters))


def _compressed(image: NDArray[np.uint8], quality: int) -> NDArray[np.uint8]:
    _, data = cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED), dtype=np.uint8)


def _isolated(pixels: NDArray[np.float64], diameters: NDArray[np.float64]) -> NDArray[np.bool_]:
    distances = np.hypot(*(pixels[:, None] - pixels[None, :]).transpose(2, 0, 1))
    np.fill_diagonal(distances, np.inf)
    mean = 0.5 * (diameters[:, None] + diameters[None, :])
    return np.asarray((distances > _ISOLATED * mean).all(axis=1))


def match(dots: DetectedDots, truth: TrueImage) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return indices of dots and of their chips: the nearest within half a diameter, each chip once."""
    if len(dots) == 0:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    distances, nearest = cKDTree(truth.pixels).query(dots.pixels)
    chips = np.asarray(nearest, dtype=np.int64)
    distances = np.asarray(distances)
    order = np.argsort(distances)
    order = order[distances[order] < 0.5 * truth.diameters[chips[order]]]
    _, first = np.unique(chips[order], return_index=True)
    return order[first], chips[order[first]]


def source_extractor(image: NDArray[np.uint8], sign: float) -> DetectedDots:
    """Return the dots that sep finds: its own background, 5 standard deviations, its own deblending."""
    grey = image.astype(np.float32).mean(axis=2) if image.ndim == 3 else image.astype(np.float32)
    signal = np.ascontiguousarray(sign * grey)
    background = sep.Background(signal)
    found = sep.extract(signal - background.back(), 5.0, err=background.globalrms, minarea=5)
    height, width = grey.shape
    whole = (found['xmin'] > 0) & (found['ymin'] > 0)
    found = found[whole & (found['xmax'] < width - 1) & (found['ymax'] < height - 1)]
    sigmas = np.sqrt(0.5 * (found['errx2'] + found['erry2']))
    diameters = 2.0 * np.sqrt(found['npix'] / np.pi)
    return DetectedDots(np.column_stack([found['x'], found['y']]), diameters, sigmas)


@dataclass
class Score:
    """What one detector made of the images of a condition."""

    wanted: int = 0
    right: int = 0
    touching: int = 0
    split: int = 0
    found: int = 0
    false: int = 0
    errors: list[NDArray[np.float64]] = field(default_factory=list)
    normalised: list[NDArray[np.float64]] = field(default_factory=list)
    times: list[float] = field(default_factory=list)

    def add(self, dots: DetectedDots, truth: TrueImage, seconds: float) -> None:
        """Count the dots of one image; errors are those of chips that stand alone."""
        matched, chips = match(dots, truth)
        touching = truth.wanted & ~truth.isolated
        self.wanted += int(truth.wanted.sum())
        self.right += int(truth.wanted[chips].sum())
        self.touching += int(touching.sum())
        self.split += int(touching[chips].sum())
        self.found += len(dots)
        self.false += len(dots) - len(matched)
        sound = (truth.wanted & truth.isolated)[chips]
        offsets = dots.pixels[matched[sound]] - truth.pixels[chips[sound]]
        self.errors.append(np.hypot(*offsets.T))
        self.normalised.append((offsets / dots.sigmas[matched[sound], None]).ravel())
        self.times.append(1e3 * seconds)

    def cells(self) -> list[str]:
        """Return the cells of the table."""
        error = np.concatenate(self.errors)
        return [
            f'{self.right / self.wanted:.3f}',
            f'{self.split / max(self.touching, 1):.2f}',
            f'{1.0 - self.false / max(self.found, 1):.3f}',
            f'{np.median(error):.3f}',
            f'{_rms(error):.3f}',
            f'{_rms(np.concatenate(self.normalised)):.2f}',
            f'{np.median(self.times):.1f}',
        ]


def _rms(values: NDArray[np.float64]) -> float:
    return math.sqrt(np.mean(values**2))


def scores_of(detectors: Sequence[Detect], images: Sequence[TrueImage]) -> list[Score]:
    """Return the detectors' scores."""
    scores = [Score() for _ in detectors]
    for detect in detectors:
        detect(images[0].image)
    for truth in images:
        for detect, score in zip(detectors, scores, strict=True):
            start = time.process_time()
            dots = detect(truth.image)
            score.add(dots, truth, time.process_time() - start)
    return scores


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description='Dots from simulated images against the truth.')
    parser.add_argument('--only', default='', help='only the conditions whose name contains this')
    parser.add_argument('--seed', type=int, default=3, help='seed of floor and noise')
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    detector = DotDetector()
    peer = 'shirube / sep' if sep is not None else 'shirube'
    print(
        f'{platform.machine()}, one core, numpy {np.__version__}, OpenCV {cv2.__version__}; values are {peer}\n'
    )
    print(f'| {" | ".join(HEADS)} |\n|{"---|" * len(HEADS)}')
    chosen = [condition for condition in CONDITIONS if arguments.only in condition.name]
    for condition in tqdm(chosen, leave=False):
        images = list(photographs(condition, arguments.seed))
        detectors: list[Detect] = [detector.detect]
        if sep is not None:
            sign = 1.0 if condition.design is LIGHT_ON_DARK else -1.0
            detectors.append(partial(source_extractor, sign=sign))
        columns = zip(*(score.cells() for score in scores_of(detectors, images)), strict=True)
        tqdm.write(f'| {condition.name} | {" | ".join(" / ".join(cells) for cells in columns)} |')
    return 0


if __name__ == '__main__':
    sys.exit(main())
