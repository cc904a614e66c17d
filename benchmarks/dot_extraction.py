"""Dots from simulated images against the truth: `./shirube bench dot_extraction`.

Prints a table of recall, precision, centroid error and time of the detector, and of Source Extractor (the
package ``sep``, made for stars) where it is installed, for one condition after the other. One core.
"""

from __future__ import annotations

import argparse
import math
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from tqdm import tqdm

from floor_localizer.core.detected_dots import DetectedDots
from floor_localizer.core.dot_extraction import DotDetector
from scene_simulator.dot_floor import COLOURED, DARK_ON_LIGHT, LIGHT_ON_DARK, FloorDesign, lay_floor
from scene_simulator.floor_camera import PAPER_CAMERA, Disturbance, FloorCamera
from scene_simulator.floor_disturbance import ShadowEdge, SpecularReflection
from scene_simulator.floor_litter import FloorArea, crumbs, dust, hairs, scratches
from scene_simulator.imaging import Lighting, Sensor
from shirube_geometry import CameraMount, PinholeCamera, PlanarPose

try:
    import sep
except ImportError:
    sep = None

Detect = Callable[[NDArray[np.uint8]], DetectedDots]

_SIZE = 1.2
_MARGIN = 0.3
_ALONE = 1.3
"""A dot stands alone when no other centre is nearer than this multiple of the mean of both diameters."""

NEAR_CAMERA = PinholeCamera(1280, 1024, 1857.0, 1857.0, 639.5, 511.5)
WIDE_CAMERA = PinholeCamera(1280, 1024, 339.44, 339.44, 639.5, 511.5)


def _shadow(x: float, y: float) -> tuple[Disturbance, ...]:
    return (ShadowEdge((x, y), 0.4 + 5.0 * x),)


def _dirt(x: float, y: float) -> tuple[Disturbance, ...]:
    area = FloorArea((x - 0.1, y - 0.1), (x + 0.1, y + 0.1))
    seed = int(1e6 * (x + y))
    return (
        crumbs(area, 300.0, seed),
        dust(area, 5000.0, seed + 1),
        hairs(area, 600.0, seed + 2),
        scratches(area, 400.0, seed + 3),
    )


def _reflection(x: float, y: float) -> tuple[Disturbance, ...]:
    return (SpecularReflection((math.sin(30.0 * x) * 0.6, math.cos(30.0 * y) * 0.6), 0.08),)


@dataclass(frozen=True)
class Condition:
    """What is photographed, and how.

    Attributes:
        name: as the table calls it.
        design: the floor.
        camera: intrinsics.
        lighting: lamps and lens.
        sensor: noise.
        colour: whether the camera takes colours.
        blur: length of the motion during the exposure [px].
        disturbances: what lies about at the place x, y of the camera [m].
        images: how many.
    """

    name: str
    design: FloorDesign = DARK_ON_LIGHT
    camera: PinholeCamera = PAPER_CAMERA
    lighting: Lighting = field(default_factory=Lighting)
    sensor: Sensor = field(default_factory=Sensor)
    colour: bool = False
    blur: float = 0.0
    disturbances: Callable[[float, float], tuple[Disturbance, ...]] | None = None
    images: int = 24


CONDITIONS = (
    Condition('clean'),
    Condition('gradient', lighting=Lighting(level=0.7, gradient=(0.6, -0.3), vignetting=0.4)),
    Condition('shadow edge', disturbances=_shadow),
    Condition('noise x3', sensor=Sensor(full_well=1000.0, read_noise=4.0)),
    Condition('blur 3 px', blur=3.0),
    Condition('blur 6 px', blur=6.0),
    Condition('blur 10 px', blur=10.0),
    Condition('dirt and hairs', disturbances=_dirt),
    Condition('reflection', disturbances=_reflection),
    Condition('light on dark', design=LIGHT_ON_DARK),
    Condition('coloured', design=COLOURED, colour=True),
    Condition('1280x1024, 0.07 mm/px', camera=NEAR_CAMERA, images=6),
    Condition('1280x1024, 0.38 mm/px', camera=WIDE_CAMERA, images=3),
)


@dataclass(frozen=True)
class TrueImage:
    """An image and its chips.

    Attributes:
        image: shape (h, w) or (h, w, 3).
        pixels: shape (n, 2), true centres of the chips with their centre in the image [px].
        diameters: shape (n,) [px].
        wanted: shape (n,), chips wholly in the image that no dirt hides.
        alone: shape (n,), chips that touch no other.
    """

    image: NDArray[np.uint8]
    pixels: NDArray[np.float64]
    diameters: NDArray[np.float64]
    wanted: NDArray[np.bool_]
    alone: NDArray[np.bool_]


def photographs(condition: Condition, seed: int) -> Iterator[TrueImage]:
    """Yield the images of a condition."""
    design = replace(condition.design, size=(_SIZE, _SIZE), count=round(5384 * _SIZE**2))
    floor = lay_floor(design, seed)
    camera = FloorCamera(condition.camera, condition.lighting, condition.sensor, condition.colour)
    rng = np.random.default_rng(seed)
    pixel = CameraMount().xyz[2] / condition.camera.fx
    for _ in range(condition.images):
        x, y = rng.uniform(_MARGIN, _SIZE - _MARGIN, 2)
        heading, course = rng.uniform(-math.pi, math.pi, 2)
        way = np.linspace(-0.5, 0.5, round(4 * condition.blur) + 1) if condition.blur else np.zeros(1)
        way *= condition.blur * pixel
        poses = [PlanarPose(x + s * math.cos(course), y + s * math.sin(course), heading) for s in way]
        disturbances = condition.disturbances(x, y) if condition.disturbances else ()
        photo = camera.photograph(floor, poses, disturbances=disturbances, rng=rng)
        chips, pixels = camera.visible_chips(floor, PlanarPose(x, y, heading))
        diameters = floor.diameters[chips] / pixel
        margin = (0.5 * diameters + 1.5 + 0.5 * condition.blur)[:, None]
        size = np.array([condition.camera.width, condition.camera.height])
        inside = ((pixels > margin) & (pixels < size - 1 - margin)).all(axis=1)
        u, v = np.clip(np.rint(pixels).astype(int), 0, size - 1).T
        clean = cv2.blur(photo.dirt, (5, 5))[v, u] < 0.05
        yield TrueImage(photo.image, pixels, diameters, inside & clean, _stand_alone(pixels, diameters))


def _stand_alone(pixels: NDArray[np.float64], diameters: NDArray[np.float64]) -> NDArray[np.bool_]:
    distances = np.hypot(*(pixels[:, None] - pixels[None, :]).transpose(2, 0, 1))
    np.fill_diagonal(distances, np.inf)
    mean = 0.5 * (diameters[:, None] + diameters[None, :])
    return np.asarray((distances > _ALONE * mean).all(axis=1))


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


def row_of(name: str, method: str, detect: Detect, images: Sequence[TrueImage]) -> str:
    """Return one row of the table."""
    detect(images[0].image)
    wanted = right = touching = parted = found = false = 0
    errors, normalised, times = [], [], []
    for truth in images:
        start = time.process_time()
        dots = detect(truth.image)
        times.append(1e3 * (time.process_time() - start))
        matched, chips = match(dots, truth)
        found += len(dots)
        false += len(dots) - len(matched)
        wanted += truth.wanted.sum()
        right += truth.wanted[chips].sum()
        touching += (truth.wanted & ~truth.alone).sum()
        parted += (truth.wanted & ~truth.alone)[chips].sum()
        sound = (truth.wanted & truth.alone)[chips]
        offsets = dots.pixels[matched[sound]] - truth.pixels[chips[sound]]
        errors.append(np.hypot(*offsets.T))
        normalised.append((offsets / dots.sigmas[matched[sound], None]).ravel())
    error = np.concatenate(errors)
    rms = math.sqrt(np.mean(error**2))
    normalised_rms = math.sqrt(np.mean(np.concatenate(normalised) ** 2))
    return (
        f'| {name} | {method} | {right / wanted:.3f} | {parted / max(touching, 1):.2f} '
        f'| {1.0 - false / max(found, 1):.3f} | {np.median(error):.3f} | {rms:.3f} '
        f'| {normalised_rms:.2f} | {np.median(times):.1f} |'
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description='Dots from simulated images against the truth.')
    parser.add_argument('--only', default='', help='only the conditions whose name contains this')
    parser.add_argument('--seed', type=int, default=3, help='seed of floor and noise')
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    detector = DotDetector()
    print(f'{platform.machine()}, one core, numpy {np.__version__}, OpenCV {cv2.__version__}\n')
    print(
        '| condition | method | recall | of touching | precision | error px | rms px | rms error/sigma | ms |'
    )
    print('|---|---|---|---|---|---|---|---|---|')
    chosen = [condition for condition in CONDITIONS if arguments.only in condition.name]
    for condition in tqdm(chosen, leave=False):
        images = list(photographs(condition, arguments.seed))
        sign = 1.0 if condition.design is LIGHT_ON_DARK else -1.0
        rows = [row_of(condition.name, 'shirube', detector.detect, images)]
        if sep is not None:
            rows.append(row_of('', 'sep', partial(source_extractor, sign=sign), images))
        tqdm.write('\n'.join(rows))


if __name__ == '__main__':
    main()
