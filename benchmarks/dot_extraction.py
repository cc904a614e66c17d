"""Dots from simulated images against the truth, compared with Source Extractor (``sep``, made for stars).

Recall, precision, centroid error and time of both detectors, for one condition after the other. One core, CPU time,
both detectors in turn on each image.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import cv2
import numpy as np
from _figures import error, rate, ratio, rms, time
from _floor_photographs import MOUNT, SurveyedFloor
from _hard_conditions import FOR_DETECTORS, HardCondition
from _harness import Option, Run, cpu_time, progress, run_benchmark, use_one_core
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DetectedDots
from scene_simulator.floor.dot_floor import LIGHT_ON_DARK

SIZE, MARGIN = 1.2, 0.3
ISOLATED = 1.3  # A dot is isolated when no other centre is nearer than this multiple of the mean of both diameters


class TrueImage(NamedTuple):
    """An image, true centres, shape (n, 2) [px], and diameters, shape (n,) [px], of the chips with their centre in it,
    and which of these are wholly in it, not hidden by dirt, and which touch no other, shape (n,).
    """

    image: NDArray[np.uint8]
    pixels: NDArray[np.float64]
    diameters: NDArray[np.float64]
    wanted: NDArray[np.bool_]
    isolated: NDArray[np.bool_]


def true_images(condition: HardCondition, count: int, seed: int) -> Iterator[TrueImage]:
    """Yield images of a condition."""
    design, camera = condition.design, condition.camera
    density = design.count / (design.size[0] * design.size[1])
    small = SurveyedFloor(replace(design, size=(SIZE, SIZE), count=round(density * SIZE**2)), seed=seed)
    pixel = MOUNT.xyz[2] / camera.fx
    for number, pose in enumerate(small.places(count, MARGIN)):
        photo = condition.photograph(small.floor, pose, np.random.default_rng([seed, number]))
        chips, pixels = condition.photographer.visible_chips(small.floor, pose)
        diameters = small.floor.diameters[chips] / pixel
        margin = (0.5 * diameters + 1.5 + 0.5 * condition.blur)[:, None]
        size = np.array([camera.width, camera.height])
        inside = ((pixels > margin) & (pixels < size - 1 - margin)).all(axis=1)
        u, v = np.clip(np.rint(pixels).astype(int), 0, size - 1).T
        clean = cv2.blur(photo.dirt, (5, 5))[v, u] < 0.05
        yield TrueImage(photo.image, pixels, diameters, inside & clean, _isolated(pixels, diameters))


def _isolated(pixels: NDArray[np.float64], diameters: NDArray[np.float64]) -> NDArray[np.bool_]:
    distances = np.hypot(*(pixels[:, None] - pixels[None, :]).transpose(2, 0, 1))
    np.fill_diagonal(distances, np.inf)
    mean = 0.5 * (diameters[:, None] + diameters[None, :])
    return np.asarray((distances > ISOLATED * mean).all(axis=1))


def match(dots: DetectedDots, truth: TrueImage) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return indices of dots and of their chips: the nearest within half a diameter, each chip once."""
    distances, chips = map(np.asarray, cKDTree(truth.pixels).query(dots.pixels))
    order = np.argsort(distances)
    order = order[distances[order] < 0.5 * truth.diameters[chips[order]]]
    _, first = np.unique(chips[order], return_index=True)
    return order[first], chips[order[first]]


def source_extractor(sep: Any, sign: float, image: NDArray[np.uint8]) -> DetectedDots:
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
    """What one detector made of the images of a condition.

    Attributes:
        counts: shape (3, 2), how many of how many: chips found, touching ones found, dots that are chips.
        errors: errors of chips that stand alone [px].
        normalised: the same, by their standard deviations.
        times: processor time of each image [ms].
    """

    counts: NDArray[np.int64] = field(default_factory=lambda: np.zeros((3, 2), dtype=np.int64))
    errors: list[NDArray[np.float64]] = field(default_factory=list)
    normalised: list[NDArray[np.float64]] = field(default_factory=list)
    times: list[float] = field(default_factory=list)

    def add(self, dots: DetectedDots, truth: TrueImage, milliseconds: float) -> None:
        """Count the dots of one image."""
        matched, chips = match(dots, truth)
        kinds = truth.wanted, truth.wanted & ~truth.isolated
        self.counts += [*((kind[chips].sum(), kind.sum()) for kind in kinds), (len(matched), len(dots))]
        sound = (truth.wanted & truth.isolated)[chips]
        offsets = dots.pixels[matched[sound]] - truth.pixels[chips[sound]]
        self.errors.append(np.hypot(*offsets.T))
        self.normalised.append((offsets / dots.sigmas[matched[sound], None]).ravel())
        self.times.append(milliseconds)


def main(run: Run, images: int, only: str) -> None:
    """Compare the detectors."""
    use_one_core()
    sep = run.peer('sep', 'sep')
    heads = 'condition | detector | recall % | of touching chips % | precision % | error px: median / 95 %'
    table = run.table('Dots in images', heads, 'error / sigma | ms | ms in units of sep')
    for condition in progress([condition for condition in FOR_DETECTORS if only in condition.name]):
        few = images if condition.camera.width < 1000 else max(images // 6, 2)
        detectors: dict[str, Callable[[NDArray[np.uint8]], DetectedDots]] = {'shirube': DotDetector().detect}
        if sep is not None:
            sign = 1.0 if condition.design is LIGHT_ON_DARK else -1.0
            detectors['sep'] = partial(source_extractor, sep, sign)
        scores = {name: Score() for name in detectors}
        for number, truth in enumerate(true_images(condition, few, run.seed)):
            for name, detect in detectors.items():
                if number == 0:
                    detect(truth.image)  # compiles
                dots, milliseconds = cpu_time(detect, truth.image)
                scores[name].add(dots, truth, milliseconds)
        for name, score in scores.items():
            shares = (rate(right, total, form='percent') for right, total in score.counts.tolist())
            table.add(
                *(condition.name, name, *shares),
                error(np.concatenate(score.errors), '.3f', shown=(50, 95)),
                rms(np.concatenate(score.normalised), '.2f', better='one'),
                time(score.times, '.1f', (50,)),
                ratio(score.times, scores['sep'].times, '.2f') if name != 'sep' and sep is not None else '',
            )


if __name__ == '__main__':
    run_benchmark(
        main,
        images=Option(24, 4, 'of each condition, a sixth of it of the large ones'),
        only=Option('', '', 'only the conditions whose name contains this'),
    )
