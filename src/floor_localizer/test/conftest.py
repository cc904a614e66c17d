"""Shared fixtures: an isolated ROS graph, and one floor for all tests."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from node_testing import graph

from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.localizer import FloorLocalizer

__all__ = ['graph']
sys.path.insert(0, str(Path(__file__).parent))  # for the helper modules of the tests

from floor_views import MOUNT, random_floor
from survey_scene import record_drive

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs the main function of a command and returns its exit code and what it printed."""

    def run_main(main: Callable[[list[str]], int], *arguments: object) -> tuple[int, str, str]:
        capsys.readouterr()
        return main([*map(str, arguments)]), *capsys.readouterr()

    return run_main


@pytest.fixture
def refusal(run: Run) -> Callable[..., str]:
    """Runs a command whose input is malformed and returns the one line that says so, beside any progress."""

    def run_and_refuse(main: Callable[[list[str]], int], *arguments: object, alone: bool = True) -> str:
        code, _, err = run(main, *arguments)
        command = main.__module__.rpartition('.')[2]
        lines = [line for line in err.splitlines() if line.startswith(f'{command}: ')]
        assert (code, len(lines)) == (1, 1), err
        assert 'Traceback' not in err
        assert not alone or err.count('\n') == 1, err
        return lines[0]

    return run_and_refuse


@pytest.fixture(scope='session')
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rendered drive over a floor as images and as a bag."""
    return record_drive(tmp_path_factory.mktemp('drive'))


@pytest.fixture(scope='session')
def floor() -> DotMap:
    """A floor of about three thousand dots, as dense as the paper's."""
    return random_floor(1)


@pytest.fixture(scope='session')
def indexed_floor(floor: DotMap) -> IndexedMap:
    """The same floor with its search index."""
    return index_map(floor)


@pytest.fixture(scope='session')
def localizer(indexed_floor: IndexedMap) -> FloorLocalizer:
    """A localizer on that floor."""
    return FloorLocalizer(indexed_floor, MOUNT)
