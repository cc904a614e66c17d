"""Benchmarks have a memory: what is compared, by which tolerance, and the tables that are made of it."""

import importlib
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytestmark = pytest.mark.newest_set_only

BENCHMARKS = Path(__file__).resolve().parents[1] / 'benchmarks'


@pytest.fixture(scope='module')
def bench() -> SimpleNamespace:
    names = ('figures', 'harness', 'results')
    return SimpleNamespace(**{name: importlib.import_module(f'_{name}') for name in names})


def result(bench: SimpleNamespace, figure: Any, **more: Any) -> Any:
    table = bench.harness.Table('Errors', ('method', 'figure'))
    table.add('ours', figure)
    found = {'benchmark': 'b', 'arguments': {}, 'tables': [table], 'commit': 'abc', 'date': 'today', **more}
    return json.loads(bench.results.as_json(found))


def verdicts(bench: SimpleNamespace, before: Any, after: Any) -> set[str]:
    changed = bench.results.compare(result(bench, before), result(bench, after))
    return {change.verdict for _, change in changed}


@pytest.mark.parametrize('kind', ['error', 'rms', 'mean'])
def test_noise_is_accepted_and_a_change_is_found(bench: SimpleNamespace, kind: str) -> None:
    make, rng = getattr(bench.figures, kind), np.random.default_rng(1)
    pairs = np.abs(rng.normal(size=(60, 2, 400)))
    alarms = [bool(verdicts(bench, make(one), make(other))) for one, other in pairs]
    assert np.mean(alarms) < 0.2
    assert verdicts(bench, make(pairs[0, 0]), make(1.5 * pairs[0, 0])) == {'worse'}
    assert verdicts(bench, make(pairs[0, 0]), make(0.6 * pairs[0, 0])) == {'better'}


def test_standard_errors_are_those_of_repeated_experiments(bench: SimpleNamespace) -> None:
    rng = np.random.default_rng(2)
    error, rms = bench.figures.error, bench.figures.rms
    for make, name in ((error, 'median'), (error, '95 %'), (rms, 'rms')):
        found = np.array([make(np.abs(rng.normal(size=500))).values[name] for _ in range(300)])
        assert found[:, 1].mean() == pytest.approx(found[:, 0].std(), rel=0.25)
    shares = np.array([bench.figures.rate(int(rng.binomial(200, 0.3)), 200).values[''] for _ in range(400)])
    assert shares[:, 1].mean() == pytest.approx(shares[:, 0].std(), rel=0.15)


def test_rates_leave_their_tolerance_by_two_standard_errors(bench: SimpleNamespace) -> None:
    rate = bench.figures.rate
    assert verdicts(bench, rate(95, 100), rate(90, 100)) == set()
    assert verdicts(bench, rate(95, 100), rate(80, 100)) == {'worse'}
    assert verdicts(bench, rate(0, 1000, 'lower'), rate(8, 1000, 'lower')) == {'worse'}


def test_ratios_of_time_leave_theirs_by_five_per_cent_and_times_never(bench: SimpleNamespace) -> None:
    ratio, ones = bench.figures.ratio, np.ones(9)
    assert verdicts(bench, ratio(2.0 * ones, ones), ratio(2.09 * ones, ones)) == set()
    assert verdicts(bench, ratio(2.0 * ones, ones), ratio(2.15 * ones, ones)) == {'worse'}
    assert verdicts(bench, ratio(2.0 * ones, ones), ratio(1.8 * ones, ones)) == {'better'}
    assert verdicts(bench, bench.figures.time(ones), bench.figures.time(9.0 * ones)) == set()


def test_what_is_gone_is_worse_and_a_consistent_error_is_near_one(bench: SimpleNamespace) -> None:
    error, rms = bench.figures.error, bench.figures.rms
    assert verdicts(bench, error([1.0, 1.0]), error([])) == {'worse'}
    ones = np.ones(500)
    assert verdicts(bench, rms(2.0 * ones, better='one'), rms(1.1 * ones, better='one')) == {'better'}
    assert verdicts(bench, rms(0.9 * ones, better='one'), rms(0.5 * ones, better='one')) == {'worse'}


def test_a_result_survives_its_file(bench: SimpleNamespace) -> None:
    figures = bench.figures
    for figure in (figures.rate(3, 9), figures.error([]), figures.outcomes(['right']), figures.count(3)):
        ((_, again),) = bench.results.figures_of(result(bench, figure))
        assert bench.figures.changes(figure, again) == []
        assert (again.kind, again.text, again.better) == (figure.kind, figure.text, figure.better)


def test_marked_tables_are_those_of_the_kept_results(bench: SimpleNamespace) -> None:
    for page in bench.results.pages():
        text = page.read_text()
        assert bench.results.update_tables(text) == text, f'{page}: ./shirube bench --tables'


def test_every_benchmark_has_a_first_line(bench: SimpleNamespace) -> None:
    for program in BENCHMARKS.glob('[!_]*.py'):
        text = program.read_text()
        assert text.startswith('"""')
        assert 'run_benchmark(' in text
        assert 'argparse' not in text


def test_spurious_depths_are_as_many_as_asked_for() -> None:
    scenes, depth = importlib.import_module('_voxel_scenes'), np.full((480, 640), 9.0, dtype=np.float32)
    for patch in (1, 8):
        image = scenes.add_spurious_depths(depth, 0.03, patch, (0.5, 5.0), np.random.default_rng(2))
        assert (image != depth).mean() == pytest.approx(0.03, rel=0.05)


def test_a_seed_makes_the_same_people_and_every_third_stands() -> None:
    films = importlib.import_module('_lamp_films')
    people = films.random_people(9, 1)
    assert people == films.random_people(9, 1)
    assert sum(person.speed == 0.0 for person in people) == 3
