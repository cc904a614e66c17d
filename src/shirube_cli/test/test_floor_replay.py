"""The recorded drive is replayed for real through a stand-in that answers with a known error."""

import sys
from pathlib import Path

import numpy as np
import pytest
from node_testing import first_seconds

from shirube_cli.floor_demo import figures_as_text, page
from shirube_cli.floor_picture import draw_floor_picture
from shirube_cli.floor_replay import FloorReplay, dirty_stretches, measure_accuracy, replay_floor_drive
from shirube_cli.project import CommandError, find_root
from shirube_cli.workspace import build_workspace

pytestmark = pytest.mark.newest_set_only

ROOT = find_root()
BAG = ROOT / 'bags' / 'floor_drive'
STAND_IN = Path(__file__).with_name('stand_in_localizer.py')
OFFSET = 0.002


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The drive as far as its first dirt."""
    return first_seconds(tmp_path_factory.mktemp('beginning') / 'bag', 7.0, BAG)


def replay_through_stand_in(bag: Path, folder: Path, exit_code: int = 0) -> FloorReplay:
    build_workspace(ROOT)
    return replay_floor_drive(ROOT, bag, folder, [sys.executable, str(STAND_IN), str(exit_code)])


@pytest.fixture(scope='module')
def replay(bag: Path, tmp_path_factory: pytest.TempPathFactory) -> FloorReplay:
    return replay_through_stand_in(bag, tmp_path_factory.mktemp('replay'))


def test_every_image_gets_its_pose_and_the_known_error_is_found(bag: Path, replay: FloorReplay) -> None:
    accuracy = measure_accuracy(replay, bag)
    assert replay.images > 60
    assert replay.images == len(accuracy.images_ns) == len(replay.trajectory)
    assert accuracy.report.coverage.fraction == 1.0
    assert accuracy.report.coverage.excluded > 0
    np.testing.assert_allclose(accuracy.errors.position, OFFSET, atol=1e-9)
    np.testing.assert_allclose(accuracy.errors.heading, 0.0, atol=1e-9)


def test_report_shows_the_figures_and_the_reasons(bag: Path, replay: FloorReplay, tmp_path: Path) -> None:
    accuracy = measure_accuracy(replay, bag)
    figures = figures_as_text(replay, accuracy)
    assert '2.000' in figures
    assert '3 x ambiguous' in figures
    dots = np.random.default_rng(1).uniform(0.0, 2.0, (1000, 2))
    draw_floor_picture(tmp_path / 'track.png', accuracy, dots)
    assert [path.name for path in tmp_path.iterdir()] == ['track.png']
    shown = page('a <bag>', figures, ['position_max is 1, more than the limit 0.5'])
    assert 'a &lt;bag&gt;' in shown
    assert 'Outside the limits: position_max is 1' in shown


def test_failing_node_is_named_with_its_log(bag: Path, tmp_path: Path) -> None:
    with pytest.raises(CommandError, match=r'exit code 3; see .*node\.log'):
        replay_through_stand_in(bag, tmp_path, exit_code=3)


def test_images_of_dirt_that_follow_each_other_are_one_stretch() -> None:
    hidden = [True, True, False, False, True, False, True]
    stretches = dirty_stretches([(10 * index, is_hidden) for index, is_hidden in enumerate(hidden)])
    assert stretches.tolist() == [[0, 10], [40, 40], [60, 60]]
    assert dirty_stretches([(0, False)]).shape == (0, 2)
