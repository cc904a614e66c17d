"""Photographs of printed dots and a picture of terrazzo: a quick part of `benchmarks/real_photographs`."""

import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.settings import DotDetectorSettings

BENCHMARK = Path(__file__).resolve().parents[1] / 'benchmarks' / 'real_photographs'
DATA = Path(os.environ.get('SHIRUBE_DATA', 'not given'))
MODULES = (
    *('card_edge', 'frame_finder', 'random_dot_pages', 'page_trials', 'page_truth'),
    *('terrazzo_trials', 'terrazzo_views'),
)

# Sheets that a human sees with all four corners, in frames of the movie: near, a stick over 0 and 3, oblique, far.
SEEN_IN_MOVIE = {5: {0, 1}, 28: {1}, 77: {0, 1}, 165: {0, 1, 7}}

needs_pages = pytest.mark.skipif(
    not (DATA / 'floor_random_dots').is_dir(), reason='SHIRUBE_DATA names no floor_random_dots/'
)
needs_terrazzo = pytest.mark.skipif(
    not (DATA / 'floor_terrazzo').is_dir(), reason='SHIRUBE_DATA names no floor_terrazzo/'
)


@pytest.fixture(scope='module')
def bench() -> Iterator[SimpleNamespace]:
    sys.path.insert(0, str(BENCHMARK))
    yield SimpleNamespace(**{name: importlib.import_module(name) for name in MODULES})
    sys.path.remove(str(BENCHMARK))


def test_the_edge_of_a_card_is_found_above_its_side(bench):
    ndtr = np.vectorize(lambda x: 0.5 * (1.0 + np.tanh(0.8 * x)))
    depth = np.arange(-4.0, 7.01, 0.5)
    edge = np.linspace(-0.4, 0.8, 12)[:, None]
    card = 200.0 - 45.0 * ndtr((depth - edge) / 0.78) - 100.0 * ndtr((depth - edge - 2.0) / 0.78)
    first, last = bench.card_edge.fit_card_edge(card, depth)
    assert first == pytest.approx(-0.4, abs=0.15)
    assert last == pytest.approx(0.8, abs=0.15)


@needs_pages
def test_the_visible_pages_of_the_photograph_are_located(bench):
    folder = DATA / 'floor_random_dots'
    pages = bench.random_dot_pages.load_pages(folder)
    image, camera = bench.random_dot_pages.load_photograph(folder)
    photograph = bench.page_truth.detect_pages(0, image, camera.matrix, pages)
    assert all(frame.is_printed for frame in photograph.frames)
    trials = list(bench.page_trials.PageBench(pages).trials(photograph, np.random.default_rng(1)))
    assert sorted(trial.page for trial in trials) == [3, 86, 87]
    assert {trial.outcome for trial in trials} == {'right'}
    assert {trial.without_it for trial in trials} == {'none'}


@needs_pages
def test_the_visible_pages_of_the_movie_are_located(bench):
    folder = DATA / 'floor_random_dots'
    pages = bench.random_dot_pages.load_pages(folder)
    matrix = bench.random_dot_pages.load_movie_camera(folder).matrix
    page_bench = bench.page_trials.PageBench(pages)
    for number, image in bench.random_dot_pages.movie_images(folder):
        if number in SEEN_IN_MOVIE:
            photograph = bench.page_truth.detect_pages(number, image, matrix, pages)
            trials = list(page_bench.trials(photograph, np.random.default_rng(1)))
            assert {trial.page for trial in trials} >= SEEN_IN_MOVIE[number]
            assert None not in {trial.page for trial in trials}
            assert {trial.outcome for trial in trials} == {'right'}
            assert {trial.without_it for trial in trials} == {'none'}


@needs_terrazzo
def test_a_picture_without_pages_has_no_frames(bench):
    picture = bench.terrazzo_views.load_terrazzo(DATA)
    assert bench.frame_finder.find_frames(picture[:256, :256, 1].copy(), np.diag([300.0, 300.0, 1.0])) == []


@needs_terrazzo
@pytest.mark.parametrize('polarity', ['auto', 'dark'])
def test_views_of_terrazzo_are_located_where_they_were_cut(bench, polarity):
    picture = bench.terrazzo_views.load_terrazzo(DATA)
    detector = DotDetector(DotDetectorSettings(polarity=polarity))
    terrazzo = bench.terrazzo_trials.TerrazzoBench(picture, detector)
    generator = np.random.default_rng(2)
    trials = [terrazzo.trial(generator) for _ in range(25)]
    right = [trial for trial in trials if trial.outcome == 'right']
    assert not [trial for trial in trials if trial.outcome == 'wrong']
    assert len(right) == 25 if polarity == 'dark' else len(right) >= 20
    assert max(trial.error for trial in right) < 0.0001
