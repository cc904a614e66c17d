"""The commands end with a file, or with one line and exit code 1."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import pytest

from scene_simulator.commands import generate_floor, record_floor_bag, render_floor_view

Run = Callable[..., int]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Run:
    def run_command(main: Callable[[], int], *arguments: object) -> int:
        monkeypatch.setattr('sys.argv', ['command', *map(str, arguments)])
        return main()

    return run_command


def test_generate_floor_writes_a_map(run: Run, tmp_path: Path) -> None:
    path = tmp_path / 'floor.csv'
    assert run(generate_floor.main, path, '--size', 0.5, 0.4, '--count', 1000, '--seed', 3) == 0
    assert len(path.read_text().splitlines()) == 1001


def test_render_floor_view_writes_a_picture(run: Run, tmp_path: Path) -> None:
    assert run(render_floor_view.main, tmp_path / 'view.png', '--time', 5.0) == 0
    assert cv2.imread(str(tmp_path / 'view.png')).shape == (470, 470, 3)


def test_record_floor_bag_writes_a_bag(run: Run, tmp_path: Path) -> None:
    assert run(record_floor_bag.main, tmp_path / 'bag', '--seconds', 0.2) == 0
    assert (tmp_path / 'bag' / 'metadata.yaml').exists()


@pytest.mark.parametrize(
    ('main', 'arguments', 'complaint'),
    [
        (generate_floor.main, ('{file}/floor.csv', '--count', 10), 'cannot be written'),
        (generate_floor.main, ('{tmp}/floor.csv', '--size', 0.01, 0.01), 'do not fit'),
        (record_floor_bag.main, ('{tmp}',), 'exists already'),
        (record_floor_bag.main, ('{tmp}/bag', '--seed', -1), 'seed'),
        (render_floor_view.main, ('{tmp}/view',), 'cannot be written'),
    ],
)
def test_a_bad_argument_ends_in_one_line(
    run: Run,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    main: Callable[[], int],
    arguments: tuple[object, ...],
    complaint: str,
) -> None:
    (tmp_path / 'file').write_text('')
    places = [str(argument).format(tmp=tmp_path, file=tmp_path / 'file') for argument in arguments]
    assert run(main, *places) == 1
    lines = [line for line in capfd.readouterr().err.splitlines() if line.strip()]
    assert len(lines) == 1
    assert complaint in lines[0]
