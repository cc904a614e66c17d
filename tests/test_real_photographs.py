"""Photographs of printed dots and a picture of terrazzo: a quick part of `benchmarks/real_photographs.py`."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.settings import DotDetectorSettings

BENCHMARK = 'real_photographs'
DATA = Path(os.environ.get('SHIRUBE_DATA', 'not given'))

needs_sheets = pytest.mark.skipif(
    not (DATA / 'floor_random_dots').is_dir(), reason='SHIRUBE_DATA names no floor_random_dots/'
)
needs_terrazzo = pytest.mark.skipif(
    not (DATA / 'floor_terrazzo').is_dir(), reason='SHIRUBE_DATA names no floor_terrazzo/'
)


@needs_sheets
def test_the_sheets_of_photograph_and_movie_are_located(bench):
    sheets, views = bench.load_sheets(DATA / bench.SHEETS), list(bench.sheet_views(DATA / bench.SHEETS, 27))
    assert {view.sheet for view in views if view.number == bench.PHOTOGRAPH} == {3, 86, 87}
    sheet_bench, generator = bench.SheetBench(sheets), np.random.default_rng(1)
    trials = [sheet_bench.trial(view, generator) for view in views]
    assert len(trials) > 20
    assert {trial.outcome for trial in trials} == {'right'}
    assert {trial.without_it for trial in trials} == {'none'}


@needs_terrazzo
@pytest.mark.parametrize('polarity', ['auto', 'dark'])
def test_views_of_terrazzo_are_located_where_they_were_cut(bench, polarity):
    picture = cv2.imread(str(DATA.joinpath(*bench.TERRAZZO)))
    detector = DotDetector(DotDetectorSettings(polarity=polarity))
    trials = list(bench.terrazzo_trials(picture, detector, 25, 2))
    right = [trial for trial in trials if trial.outcome == 'right']
    assert not [trial for trial in trials if trial.outcome == 'wrong']
    assert len(right) == 25 if polarity == 'dark' else len(right) >= 20
    assert max(trial.error for trial in right) < 0.0001
