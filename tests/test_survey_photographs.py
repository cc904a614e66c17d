"""Printed sheets surveyed from photographs: a quick part of `benchmarks/real_photographs/survey_sheets.py`."""

import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARK = Path(__file__).resolve().parents[1] / 'benchmarks' / 'real_photographs'
FOLDER = Path(os.environ.get('SHIRUBE_DATA', 'not given')) / 'floor_random_dots'

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason='SHIRUBE_DATA names no floor_random_dots/')


@pytest.fixture(scope='module')
def bench() -> Iterator[ModuleType]:
    sys.path.insert(0, str(BENCHMARK))
    yield importlib.import_module('survey_sheets')
    sys.path.remove(str(BENCHMARK))


@pytest.mark.timeout(300)
def test_sheets_are_surveyed_and_located_in_views_that_were_kept_out(bench):
    sheets = importlib.import_module('random_dot_sheets').load_sheets(FOLDER)
    views = bench.views_by_sheet(FOLDER, sheets, 21)
    surveyed = [sheet for sheet in sorted(views) if len(views[sheet]) >= 8]
    assert len(surveyed) >= 2
    for sheet in surveyed:
        score = bench.survey_sheet(sheets[sheet], views[sheet])
        assert len(score.found.pairs) >= 29
        assert score.extra == 0
        assert score.found.rms < 0.0002
        on_surveyed, on_true, tried = score.right
        assert on_surveyed >= on_true
        assert on_surveyed >= tried - 1
