"""Tests of the command plan."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from reward_planner.commands.plan import main
from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.files.occupancy_map_file import save_occupancy_map

FRAME = GridFrame(-1.0, -2.0, 0.1, 60, 40)


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A room with a wall across that leaves a gap at the top."""
    occupancy = np.zeros(FRAME.shape, dtype=np.int8)
    occupancy[:30, 30] = 100
    path = tmp_path / 'room.yaml'
    save_occupancy_map(path, OccupancyMap(FRAME, occupancy))
    return path


def plan(room: Path, start: str, goal: str, *options: str) -> int:
    return main([str(room), '--start', *start.split(), '--goal', *goal.split(), *options])


@pytest.mark.parametrize('mode', [['--mode', 'optimal'], ['--mode', 'reward', '--visits', 'counted']])
def test_the_route_goes_around_the_wall_in_metres(room: Path, tmp_path: Path, mode: list[str], capsys) -> None:
    csv, png = tmp_path / 'route.csv', tmp_path / 'route.png'
    assert plan(room, '0.04 -1.0', '4.0 -1.0', *mode, '--csv', str(csv), '--png', str(png)) == 0
    points = np.loadtxt(csv, delimiter=',', skiprows=1)
    assert csv.read_text().startswith('x,y\n')
    assert np.abs(points[0] - (0.04, -1.0)).max() <= 0.05 + 1e-9
    assert np.abs(points[-1] - (4.0, -1.0)).max() <= 0.05 + 1e-9
    wall_ends = np.array([[2.05, y] for y in np.arange(-1.95, 1.0, 0.1)])
    assert np.linalg.norm(points[:, None] - wall_ends[None], axis=2).min() > 0.2
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert capsys.readouterr().out.startswith(f'{length:.3f} m')
    picture = cv2.imread(str(png))
    assert picture.shape[0] / picture.shape[1] == pytest.approx(40 / 60)


def test_the_rewards_of_every_step_are_reported(room: Path, tmp_path: Path) -> None:
    """Table 1 by hand: 100/L - L, and -1000, -250, -100 for what is wrong with a step."""
    csv, why = tmp_path / 'route.csv', tmp_path / 'why.csv'
    options = ['--mode', 'reward', '--robot-radius', '0', '--csv', str(csv), '--explain', str(why)]
    assert plan(room, '0.04 -1.0', '4.0 -1.0', *options) == 0
    route = np.loadtxt(csv, delimiter=',', skiprows=1)
    rows = np.genfromtxt(why, delimiter=',', names=True)
    assert len(rows) == 8 * (len(route) - 1)
    taken = rows[rows['taken'] == 1]
    np.testing.assert_allclose(np.column_stack([taken['to_x'], taken['to_y']]), route[1:], atol=1e-6)
    assert (taken['can_enter'] == 1).all()
    away = np.hypot(rows['to_x'] - route[-1, 0], rows['to_y'] - route[-1, 1]) / 0.1
    ahead = (rows['can_enter'] == 1) & (away > 0.5)
    np.testing.assert_allclose(rows['advance'][ahead], 100.0 / away[ahead] - away[ahead], atol=2e-3)
    assert set(rows['collision']) == {0.0, -1000.0}
    assert set(rows['visited']) == {0.0, -250.0}
    assert set(rows['detour']) == {0.0, -100.0}
    sums = sum(rows[name] for name in ('advance', 'collision', 'outside', 'visited', 'detour'))
    np.testing.assert_allclose(rows['total'], sums, atol=3e-3)


def test_the_picture_has_north_up(room: Path, tmp_path: Path) -> None:
    assert plan(room, '0 0', '1 1', '--png', str(tmp_path / 'a.png')) == 0
    picture = cv2.imread(str(tmp_path / 'a.png'))
    scale = picture.shape[1] // 60
    wall = (picture[:, 30 * scale + scale // 2] == 0).all(axis=1)
    assert not wall[: 10 * scale].any()
    assert wall[10 * scale :].all()


def test_the_route_keeps_distance_unless_the_shortest_is_asked_for(room: Path, tmp_path: Path, capsys) -> None:
    lengths, gaps = [], []
    for options in (['--cost-scaling-factor', '0'], []):
        csv = tmp_path / 'route.csv'
        assert plan(room, '0.04 -1.0', '4.0 -1.0', '--csv', str(csv), *options) == 0
        lengths.append(float(capsys.readouterr().out.split()[0]))
        gaps.append(np.hypot(*(np.loadtxt(csv, delimiter=',', skiprows=1) - (2.05, 0.95)).T).min())
    assert lengths[0] <= lengths[1] < 1.15 * lengths[0]
    assert gaps[0] < 0.35
    assert gaps[1] > 0.5


def test_unknown_cells_and_masks_block_if_they_shall(tmp_path: Path, capsys) -> None:
    occupancy = np.zeros(FRAME.shape, dtype=np.int8)
    occupancy[:, 30] = -1
    for name, cells in (('map', occupancy), ('mask', np.where(occupancy < 0, 100, 0).astype(np.int8))):
        save_occupancy_map(tmp_path / f'{name}.yaml', OccupancyMap(FRAME, cells))
    path = tmp_path / 'map.yaml'
    assert plan(path, '0 0', '4 0') == 0
    for options in (['--unknown', 'blocked'], ['--keepout', str(tmp_path / 'mask.yaml')]):
        assert plan(path, '0 0', '4 0', *options) == 1
        assert 'obstacles block every path' in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(['--help'])
    assert '--unknown {free,blocked}' in capsys.readouterr().out


@pytest.mark.parametrize(
    ('start', 'goal', 'options', 'message'),
    [
        ('0 0', '99 0', [], 'the goal is outside of the map'),
        ('-9 0', '0 0', [], 'the start is outside of the map'),
        ('0 0', '2.05 -1', [], 'the goal is in an obstacle or too near to one'),
        ('2.2 -1', '0 0', [], 'the start is in an obstacle or too near to one'),
        ('0 0', '4 0', ['--robot-radius', '1.2'], 'obstacles block every path'),
        ('0 nan', '4 0', [], 'not finite'),
        ('0 0', '4 0', ['--mode', 'best'], "setting mode is 'best'"),
        ('0 0', '4 0', ['--visits', 'twice'], "setting visits is 'twice'"),
        ('0 0', '4 0', ['--robot-radius', '-1'], 'setting robot_radius is -1.0'),
        ('0 0', '4 0', ['--resolution', '0.05'], 'it must be 0.05 m'),
        ('0 0', '4 0', ['--cost-scaling-factor', '-1'], 'setting cost_scaling_factor is -1.0'),
        ('0 0', '4 0', ['--keepout', 'none.yaml'], 'none.yaml: cannot be read'),
        ('0 0', '4 0', ['--csv', '/dev/null/route.csv'], 'writable path'),
        ('0 0', '4 0', ['--explain', 'why.csv'], 'needs --mode reward'),
        ('0 0', '4 0', ['--csv', '/proc/a.csv'], 'plan: /proc/a.csv: '),
    ],
)
def test_what_cannot_be_planned_is_reported_in_one_line(room, start, goal, options, message, capsys) -> None:
    assert plan(room, start, goal, *options) == 1
    said = capsys.readouterr()
    assert message in said.err
    assert said.err.startswith('plan: ')
    assert said.err.count('\n') == 1
    assert not said.out
