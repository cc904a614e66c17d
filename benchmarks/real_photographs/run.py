"""Locate real photographs without a prior: printed random-dot pages and terrazzo. Prints markdown.

``SHIRUBE_DATA`` names the folder that holds ``floor_random_dots/`` and ``floor_terrazzo/`` (BoofCV-Data, CC BY 4.0, and
terrazzo018 of ambientCG, CC0).
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np
from page_report import page_report
from page_trials import PageBench, PageTrial
from page_truth import Photograph, detect_all_pages
from random_dot_pages import FOLDER, load_movie_camera, load_pages, load_photograph, movie_images
from terrazzo_report import chip_report, view_report
from terrazzo_trials import TerrazzoBench
from terrazzo_views import load_terrazzo
from tqdm import tqdm

from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.settings import DotDetectorSettings

MOVIE_LENGTH = 294
SEED = 1


def main() -> int:
    """Run the benchmark and return its exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--every', type=int, default=1, help='use every n-th frame of the movie (default 1)')
    parser.add_argument(
        '--views', type=int, default=1000, help='views to cut from the terrazzo (default 1000)'
    )
    arguments = parser.parse_args()
    if 'SHIRUBE_DATA' not in os.environ:
        print(
            'SHIRUBE_DATA: set it to the folder that holds floor_random_dots/ and floor_terrazzo/',
            file=sys.stderr,
        )
        return 1
    data = Path(os.environ['SHIRUBE_DATA'])
    print('# Real photographs\n')
    print(f'Python {platform.python_version()}, numpy {np.__version__}, OpenCV {cv2.__version__}.\n')
    _run_pages(data / FOLDER, arguments.every)
    _run_terrazzo(data, arguments.views)
    return 0


def _run_pages(folder: Path, every: int) -> None:
    pages = load_pages(folder)
    image, camera = load_photograph(folder)
    photograph = detect_all_pages([(0, image)], camera.matrix, pages)
    images = tqdm(movie_images(folder, every), 'frames', (MOVIE_LENGTH - 1) // every + 1, leave=False)
    movie = detect_all_pages(images, load_movie_camera(folder).matrix, pages)
    bench = PageBench(pages)
    print('## Printed pages among the map of all 120\n')
    print(page_report('image00.jpg', photograph, _locate(bench, photograph), is_printed=True))
    print(page_report('movie.mp4', movie, _locate(bench, movie), is_printed=False))


def _locate(bench: PageBench, photographs: Iterable[Photograph]) -> list[PageTrial]:
    generator = np.random.default_rng(SEED)
    return [trial for photograph in photographs for trial in bench.trials(photograph, generator)]


def _run_terrazzo(data: Path, views: int) -> None:
    picture = load_terrazzo(data)
    print('## Terrazzo\n')
    print(chip_report(picture, DotDetector()))
    trials = {}
    for polarity in ('auto', 'dark', 'any'):
        bench = TerrazzoBench(picture, DotDetector(DotDetectorSettings(polarity=polarity)))
        generator = np.random.default_rng(SEED)
        trials[polarity] = [
            bench.trial(generator) for _ in tqdm(range(views), f'views, {polarity}', leave=False)
        ]
    print(view_report(trials))


if __name__ == '__main__':
    sys.exit(main())
