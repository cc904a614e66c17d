"""The page of the papers: up to date, and its mutations are applicable. `run_mutations.py` makes them."""

import ast
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / 'docs'))

import write_papers  # noqa: E402

pytestmark = pytest.mark.newest_set_only

ROWS = [(name, row) for name, paper in write_papers.load_papers().items() for row in paper['rows']]
MUTATIONS = [pytest.param(row['mutation'], id=f'{name}: {row["of"]}') for name, row in ROWS if 'mutation' in row]


def test_the_page_is_up_to_date() -> None:
    assert write_papers.PAGE.read_text() == write_papers.papers_page()


@pytest.mark.parametrize('mutation', MUTATIONS)
def test_a_mutation_changes_one_place_of_a_valid_file(mutation: dict[str, Any]) -> None:
    source = (ROOT / mutation['file']).read_text()
    assert source.count(mutation['find']) == 1
    ast.parse(source.replace(mutation['find'], mutation['replace']))
    assert mutation['find'] != mutation['replace']


@pytest.mark.parametrize('mutation', MUTATIONS)
def test_the_tests_of_a_mutation_exist(mutation: dict[str, Any]) -> None:
    for test in mutation['tests']:
        path, _, function = test.partition('::')
        assert (ROOT / path).exists()
        assert not function or f'def {function.partition("[")[0]}(' in (ROOT / path).read_text()
