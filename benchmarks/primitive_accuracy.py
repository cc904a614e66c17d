"""Primitives of drawn shapes against the truth, and the time of each stage: `./shirube bench primitive_accuracy`.

Prints the markdown of the sections "Primitives" of stereo_landmark.md. The time is taken on the photographs of
``stereo_euroc/`` (EuRoC V1_01) in the folder that SHIRUBE_DATA names, and left out where there are none.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from _primitive_pictures import (
    Condition,
    Picture,
    contour_centre,
    ellipse_picture,
    lsd_corners,
    quadrilateral_picture,
)
from numpy.typing import NDArray
from tqdm import tqdm

from stereo_landmark.core.edges.edges import extract_edges
from stereo_landmark.core.edges.segments import Segments, trace_segments
from stereo_landmark.core.primitives.corner import detect_corners
from stereo_landmark.core.primitives.ellipse import detect_ellipses, refine_ellipse
from stereo_landmark.core.primitives.line_segments import fit_line_segments
from stereo_landmark.core.primitives.parallel_lines import detect_parallel_lines
from stereo_landmark.core.primitives.primitive import Primitive, refine
from stereo_landmark.core.primitives.quadrilateral import (
    Quadrilateral,
    detect_quadrilaterals,
    refine_quadrilateral,
)
from stereo_landmark.core.settings import EdgeSettings, PrimitiveSettings
from stereo_landmark.files.camera_files import load_grey_image

CONDITIONS = (
    Condition(),
    *(Condition(size=size) for size in (8.0, 12.0, 40.0, 80.0)),
    *(Condition(contrast=contrast) for contrast in (10.0, 20.0, 40.0, 140.0)),
    *(Condition(noise=noise) for noise in (0.3, 1.0, 4.0, 8.0)),
    *(Condition(blur=blur) for blur in (0.0, 0.4, 1.2, 2.0, 3.0)),
)

HEADS = (
    *('size px', 'contrast', 'noise', 'blur px', 'found', 'rms error px', 'mean error px'),
    *('rms error / sigma', 'rms error / bound', 'before refinement px'),
)

_SEGMENTS = 1000
_PRIMITIVES = PrimitiveSettings()


@dataclass
class Score:
    """Errors of one condition, and those that the parts and the peer make."""

    pictures: int = 0
    errors: list[NDArray[np.float64]] = field(default_factory=list)
    bounds: list[float] = field(default_factory=list)
    normalised: list[float] = field(default_factory=list)
    detected: list[NDArray[np.float64]] = field(default_factory=list)
    peer: list[NDArray[np.float64]] = field(default_factory=list)

    def cells(self) -> list[str]:
        """Return the cells of the table."""
        found = f'{len(self.errors)}/{self.pictures}'
        peer = f'{_rms(self.peer)} ({len(self.peer)}/{self.pictures})'
        if not self.errors:
            return [found, '-', '-', '-', '-', '-', peer]
        bound = math.sqrt(np.mean(self.bounds))
        rms = math.sqrt(np.mean(np.square(self.errors)))
        return [
            *(found, f'{rms:.4f}', f'{np.abs(np.mean(self.errors, axis=0)).max():.4f}'),
            *(f'{math.sqrt(np.mean(self.normalised)):.2f}', f'{rms / bound:.2f}'),
            *(_rms(self.detected), peer),
        ]


def _rms(errors: Sequence[NDArray[np.float64]]) -> str:
    return f'{math.sqrt(np.mean(np.square(errors))):.4f}' if errors else '-'


def segments_of(image: NDArray[np.uint8], settings: EdgeSettings) -> Segments:
    """Return the segments of an image."""
    return trace_segments(extract_edges(image, settings), settings)


def score_ellipse(score: Score, picture: Picture, settings: EdgeSettings) -> None:
    """Add what is made of a photograph of one ellipse: found within 3 px, detected and refined."""
    score.pictures += 1
    peer = contour_centre(picture.image)
    if peer is not None and np.hypot(*(peer - picture.truth)) < 3.0:
        score.peer.append(peer - picture.truth)
    for ellipse in detect_ellipses(segments_of(picture.image, settings), _PRIMITIVES):
        refined = refine_ellipse(ellipse, picture.image)
        if np.hypot(*(ellipse.centre - picture.truth)) < 3.0 and refined is not None:
            error = refined.centre - picture.truth
            _add(score, picture, ellipse.centre - picture.truth, error, refined.covariance[:2, :2])
            return


def score_quadrilateral(score: Score, picture: Picture, settings: EdgeSettings) -> None:
    """Add what is made of a photograph of one quadrilateral: each corner found within 3 px, and refined."""
    score.pictures += 1
    peer = lsd_corners(picture.image, picture.truth)
    if peer is not None and np.abs(peer - picture.truth).max() < 3.0:
        score.peer.append(peer - picture.truth)
    sides = fit_line_segments(segments_of(picture.image, settings), _PRIMITIVES)
    for found in detect_quadrilaterals(sides, _PRIMITIVES):
        quadrilateral = _in_order(found, picture.truth)
        refined = refine_quadrilateral(quadrilateral, picture.image)
        if np.abs(quadrilateral.corners.ravel() - picture.truth).max() < 3.0 and refined is not None:
            error = refined.corners.ravel() - picture.truth
            _add(score, picture, quadrilateral.corners.ravel() - picture.truth, error, refined.covariance)
            return


def _in_order(found: Quadrilateral, truth: NDArray[np.float64]) -> Quadrilateral:
    return min(
        (found.rotate_corners(k) for k in range(4)),
        key=lambda q: float(np.abs(q.corners.ravel() - truth).max()),
    )


def _add(
    score: Score,
    picture: Picture,
    detected: NDArray[np.float64],
    error: NDArray[np.float64],
    covariance: NDArray[np.float64],
) -> None:
    score.detected.append(detected)
    score.errors.append(error)
    score.bounds.append(picture.bound)
    score.normalised.append(float(error @ np.linalg.solve(covariance, error)) / len(error))


def print_table(
    title: str,
    peer: str,
    draw: Callable[[Condition, int], Picture],
    add: Callable[[Score, Picture, EdgeSettings], None],
    count: int,
) -> None:
    """Print the table of one primitive."""
    print(f'\n### {title}\n\n| {" | ".join((*HEADS, peer))} |\n|{"---|" * (len(HEADS) + 1)}')
    for condition in tqdm(CONDITIONS, leave=False):
        # What a person would teach for the place: edges above the noise.
        settings = EdgeSettings(threshold=2.0 if condition.contrast < 30.0 else 6.0)
        score = Score()
        for seed in range(count):
            add(score, draw(condition, seed), settings)
        tqdm.write(f'| {condition} | {" | ".join(score.cells())} |')


def stages(image: NDArray[np.uint8], settings: EdgeSettings) -> Iterable[tuple[str, float, int]]:
    """Yield name, CPU time [ms] and number of results of each stage."""
    start = time.process_time()
    edges = extract_edges(image, settings)
    yield 'edges', 1e3 * (time.process_time() - start), len(edges)
    start = time.process_time()
    segments = trace_segments(edges, settings)
    yield 'segments', 1e3 * (time.process_time() - start), len(segments)
    start = time.process_time()
    sides = fit_line_segments(segments, _PRIMITIVES)
    yield 'sides', 1e3 * (time.process_time() - start), len(sides)
    detectors: tuple[tuple[str, Callable[[], Sequence[object]]], ...] = (
        ('corners', partial(detect_corners, sides, _PRIMITIVES)),
        ('parallel lines', partial(detect_parallel_lines, sides, _PRIMITIVES)),
        ('quadrilaterals', partial(detect_quadrilaterals, sides, _PRIMITIVES)),
        ('ellipses', partial(detect_ellipses, segments, _PRIMITIVES)),
    )
    for name, detect in detectors:
        start = time.process_time()
        found = detect()
        yield name, 1e3 * (time.process_time() - start), len(found)
    start = time.process_time()
    lines = cv2.createLineSegmentDetector().detect(image)[0]
    yield 'peer: cv2 LSD, segments only', 1e3 * (time.process_time() - start), len(lines)


def settings_for(image: NDArray[np.uint8], wanted: int) -> EdgeSettings:
    """Return settings with the threshold at which an image has about so many segments."""
    thresholds = np.geomspace(0.6, 20.0, 40).tolist()
    return min(
        (EdgeSettings(threshold=threshold) for threshold in thresholds),
        key=lambda settings: abs(len(segments_of(image, settings)) - wanted),
    )


def print_times(path: Path, repeats: int) -> None:
    """Print the time of each stage on one photograph."""
    image = load_grey_image(path)
    settings = settings_for(image, _SEGMENTS)
    list(stages(image, settings))
    runs = [list(stages(image, settings)) for _ in tqdm(range(repeats), leave=False)]
    names = [name for name, _, _ in runs[0]]
    times = np.array([[milliseconds for _, milliseconds, _ in run] for run in runs])
    shape = f'{image.shape[1]} x {image.shape[0]} px, threshold {settings.threshold:.2f}'
    print(f'\n{path.name}, {shape}:\n\n| stage | results | ms: median / 95 % |\n|---|---|---|')
    for k, name in enumerate(names):
        median, high = np.percentile(times[:, k], (50, 95))
        if k == len(names) - 1:
            total = times[:, :-1].sum(axis=1)
            print(f'| **all** | | **{np.median(total):.1f} / {np.percentile(total, 95):.1f}** |')
        print(f'| {name} | {runs[0][k][2]} | {median:.1f} / {high:.1f} |')
    print_refinement(image, settings)


def print_refinement(image: NDArray[np.uint8], settings: EdgeSettings) -> None:
    """Print what it takes to refine one primitive of each kind: the mean over those of an image."""
    segments = segments_of(image, settings)
    sides = fit_line_segments(segments, _PRIMITIVES)
    cells = []
    kinds: tuple[tuple[str, Sequence[Primitive]], ...] = (
        ('ellipse', detect_ellipses(segments, _PRIMITIVES)),
        ('quadrilateral', detect_quadrilaterals(sides, _PRIMITIVES)),
        ('pair of lines', detect_parallel_lines(sides, _PRIMITIVES)),
        ('corner', detect_corners(sides, _PRIMITIVES)),
    )
    for name, found in kinds:
        if found:
            refine(found[0], image)
            start = time.process_time()
            for primitive in found[:100]:
                refine(primitive, image)
            cells.append(f'{name} {1e3 * (time.process_time() - start) / len(found[:100]):.2f}')
    print(f'\nTo refine one, ms: {", ".join(cells)}.')


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description='Primitives of drawn shapes against the truth; times.')
    parser.add_argument('--pictures', type=int, default=100, help='pictures of each condition')
    parser.add_argument('--repeats', type=int, default=40, help='runs of each photograph')
    parser.add_argument('--only', choices=('ellipse', 'quadrilateral', 'time'), help='only this section')
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    if arguments.only in (None, 'ellipse'):
        peer = 'cv2.fitEllipseDirect px (found)'
        print_table('Centre of an ellipse', peer, ellipse_picture, score_ellipse, arguments.pictures)
    if arguments.only in (None, 'quadrilateral'):
        peer = 'cv2 LSD px (found)'
        print_table(
            'Corners of a quadrilateral', peer, quadrilateral_picture, score_quadrilateral, arguments.pictures
        )
    if arguments.only in (None, 'time'):
        print('\n### Time')
        photographs = sorted(
            (Path(os.environ.get('SHIRUBE_DATA', 'not given')) / 'stereo_euroc').glob('*_left.png')
        )
        for path in photographs:
            print_times(path, arguments.repeats)
        if not photographs:
            print('SHIRUBE_DATA: set it to the folder that holds stereo_euroc/', file=sys.stderr)
    return 0


if __name__ == '__main__':
    sys.exit(main())
