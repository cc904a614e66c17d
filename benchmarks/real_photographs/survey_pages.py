"""Printed random-dot pages surveyed from photographs, and located in photographs that were kept out. Prints Markdown.

    SHIRUBE_DATA=<folder with floor_random_dots/> python benchmarks/real_photographs/survey_pages.py

Each page in the movie is a little floor of 30 dots. Every other view of it, with its frame's pose plus 10 mm and 3
degrees of noise as odometry, makes a map; the views in between are located on that map and on the true one.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from card_outlines import frame_of
from numpy.typing import NDArray
from page_truth import detect_all_pages, framed_page
from page_views import DOT_DIAMETER, VIEW_CAMERA, VIEW_MOUNT, page_view, random_view_pose
from random_dot_pages import FOLDER, load_movie_camera, load_pages, movie_images
from tqdm import tqdm

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.array_store import MemoryArrayStore
from floor_localizer.core.survey.floor_survey import survey_floor
from floor_localizer.core.survey.map_comparison import MapComparison, compare
from floor_localizer.core.survey.submap import Submap, build_submap
from floor_localizer.core.survey.survey_image import SurveyImage, survey_image, view_outline
from shirube_core.geometry import SE2

POSITION_NOISE, HEADING_NOISE = 0.01, math.radians(3.0)
SETTINGS = SurveySettings(
    odometry_position_tolerance=0.045,
    odometry_yaw_tolerance=0.25,
    scale_sigma=0.01,
    tilt_sigma=0.01,
    dot_sigma=0.0002,
)
LEAST_VIEWS = 8
RIGHT = 0.001
"""A pose this near to the frame's is right: the frames are cut by hand [m]."""

View = tuple[NDArray[np.uint8], SE2]


def main() -> int:
    """Survey each page that is seen often enough, and print a line for it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        '--every', type=int, default=7, help='take each so-many-th frame (default: %(default)s)'
    )
    every = parser.parse_args().every
    folder = Path(os.environ['SHIRUBE_DATA']) / FOLDER
    pages = load_pages(folder)
    views = views_by_page(folder, pages, every)
    print(
        '| sheet | views surveyed | dots of 30 | extra | distance mm: rms / max '
        '| held out: right on surveyed / true map |'
    )
    print('|---|---|---|---|---|---|')
    for page, seen in sorted(views.items()):
        if len(seen) >= LEAST_VIEWS:
            print(line(page, pages[page], seen))
    return 0


def views_by_page(folder: Path, pages: list[NDArray[np.float64]], every: int) -> dict[int, list[View]]:
    """Return views from straight above of each page, with the robot's pose on the page."""
    camera, rng = load_movie_camera(folder), np.random.default_rng(5)
    found: dict[int, list[View]] = {}
    for photograph in detect_all_pages(tqdm(movie_images(folder, every)), camera.matrix, pages):
        for frame in photograph.frames:
            known = framed_page(photograph, frame)
            if known is not None:
                page, corners = known
                pose = random_view_pose(rng)
                outline = frame_of(page, is_printed=frame.is_printed)
                found.setdefault(page, []).append((page_view(photograph.image, corners, outline, pose), pose))
    return found


@dataclass(frozen=True)
class PageScore:
    """A surveyed page.

    Attributes:
        images: that were used, of those that were given.
        found: map from the survey, in the true map's frame.
        extra: dots of the map that are not on the page.
        right: views that were kept out and have the right pose on the surveyed and on the true map, and their number.
    """

    images: tuple[int, int]
    found: MapComparison
    extra: int
    right: tuple[int, int, int]


def survey_page(dots: NDArray[np.float64], views: list[View]) -> PageScore:
    """Survey one page by every other view and locate the others.

    Raises:
        FloorLocalizerError: the views do not make a map.
    """
    true_map, kept_out = DotMap(dots, np.full(len(dots), DOT_DIAMETER)), views[1::2]
    images, outline = noisy_images(views[::2]), view_outline(VIEW_CAMERA, VIEW_MOUNT)
    result = survey_floor(
        images, build_submaps_of(images), outline, np.array(VIEW_MOUNT.xyz), SETTINGS, MemoryArrayStore()
    )
    # Hands and cut edges stand in a few views.
    often = result.counts >= max(2, len(result.images) // 4)
    surveyed = DotMap(result.dot_map.points[often], result.dot_map.diameters[often])
    found = compare(true_map, surveyed)
    on_surveyed = right_poses(surveyed, kept_out, found.T_first_second)
    on_true = right_poses(true_map, kept_out, SE2(0.0, 0.0, 0.0))
    return PageScore(
        (len(result.images), len(images)),
        found,
        len(surveyed) - len(found.pairs),
        (on_surveyed, on_true, len(kept_out)),
    )


def line(page: int, dots: NDArray[np.float64], views: list[View]) -> str:
    """Return the line of the table for one page."""
    try:
        score = survey_page(dots, views)
    except FloorLocalizerError as fault:
        return f'| {page} | {fault} | | | | |'
    used, given = score.images
    surveyed, true, tried = score.right
    apart = f'{1e3 * score.found.rms:.3f} / {1e3 * score.found.largest:.3f}'
    numbers = f'{used} of {given} | {len(score.found.pairs)} | {score.extra}'
    return f'| {page} | {numbers} | {apart} | {surveyed} / {true} of {tried} |'


def noisy_images(views: list[View]) -> list[SurveyImage]:
    """Return the dots of views with their poses as bad odometry."""
    rng, detector, images = np.random.default_rng(9), DotDetector(), []
    for number, (view, pose) in enumerate(views):
        x, y = rng.normal(0.0, POSITION_NOISE, 2)
        odometry = replace(pose, x=pose.x + x, y=pose.y + y, yaw=pose.yaw + rng.normal(0.0, HEADING_NOISE))
        images.append(
            survey_image(f'view {number}', odometry, detector.detect(view), VIEW_CAMERA, VIEW_MOUNT)
        )
    return images


def build_submaps_of(images: list[SurveyImage]) -> list[Submap]:
    """Put views together as far as they follow each other."""
    submaps, first = [], 0
    while first < len(images):
        submap = build_submap(
            images, first, len(images) - 1, np.array(VIEW_MOUNT.xyz), SETTINGS, is_continuation=False
        )
        submaps.append(submap)
        first = int(submap.images[-1]) + 1
    return submaps


def right_poses(dot_map: DotMap, views: list[View], T_page_map: SE2) -> int:
    """Return in how many views the right pose is found on a map."""
    localizer = FloorLocalizer(index_map(dot_map), VIEW_MOUNT)
    fixes = [(localizer.locate(view, VIEW_CAMERA), pose) for view, pose in views]
    return sum(
        isinstance(fix, Fix) and (T_page_map @ fix.T_map_base).distance_to(pose) < RIGHT
        for fix, pose in fixes
    )


if __name__ == '__main__':
    sys.exit(main())
