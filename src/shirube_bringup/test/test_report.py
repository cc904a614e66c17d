"""The report of a synthetic mission shows its results and failures."""

import math
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

from scene_simulator.mission.layout import mission_layout
from shirube_bringup.commands.picture import main as picture
from shirube_bringup.record import GoalRecord, GridMap, MissionRecord, MissionTraces, StatusCount, as_array, pose_errors
from shirube_bringup.report import moving_picture
from shirube_bringup.report.page import PICTURES, goal_table, page, write_report
from shirube_bringup.report.replay import replay_data
from shirube_bringup.report.trace_errors import align_to_map, zone_spans
from shirube_core.geometry import SE2

pytestmark = pytest.mark.newest_set_only
GOOD = GoalRecord(True, 10.0, 0.012, 0.02, 0.008)
FAR = GoalRecord(True, 10.0, 0.031, 0.02, 0.008)


def mission(*goals: GoalRecord, collision_at: float = math.inf) -> tuple[dict[str, object], MissionTraces]:
    """Return summary and traces of a drive along y = 3.5 m, ten seconds a goal."""
    record = MissionRecord(0, list(goals), ended='made up')
    record.legs = [(10.0 * k, 10.0 * (k + 1)) for k in range(len(goals))]
    for k in range(500 * len(goals) + 1):
        time = 0.02 * k
        clearance = -0.01 if abs(time - collision_at) < 0.1 else 0.3
        record.add_step(time, SE2(1.0 + 0.2 * time, 3.5, 0.0), clearance)
    fused = [(0.1 * k, 1.0 + 0.02 * k, 3.503, 0.0) for k in range(100 * len(goals))]
    poses = {'pose_arbiter': fused, 'vlc_beacon': fused[::2]}
    summary = record.summary(3, poses, [(4.0, 'slow 0.2')], {'start': 1.0, 'drive': 20.0, 'whole': 22.0})
    poses['odometry'] = [(t, 0.02 * k, 0.0, 0.0) for k, (t, *_) in enumerate(fused)]
    trust = [StatusCount(float(k), 'vlc_beacon', 'used', 10 * k) for k in range(1, 20)]
    trust += [StatusCount(float(k), 'vlc_beacon', 'gated', 5 * k) for k in range(8, 20)]
    traces = MissionTraces(
        mission_layout(0),
        ((3.0, 2.0, 0.0, 3.5, 2.4, 0.7),),
        record.track,
        record.clearances,
        poses,
        record.legs,
        trust,
        GridMap((0.0, 0.0), 1.0, (2, 3), [-1, 0, 100, 0, 0, 100]),
        [(float(k), 1.5 * k) for k in range(30)],
        {'vlc_beacon': 12.0, 'pictures': 30.0},
        {'floor': (10.0, 9.9)},
    )
    return summary, traces


def verdicts(*goals: GoalRecord, collision_at: float = math.inf) -> list[str]:
    return re.findall('>(pass|FAIL)<', goal_table(*mission(*goals, collision_at=collision_at)))


def test_a_goal_outside_the_limits_is_shown_as_failed():
    assert verdicts(GOOD, FAR) == ['pass', 'FAIL', 'FAIL']  # the mission never came to the last one
    shown = page(*mission(GOOD, FAR, GOOD))
    assert 'class="failed"><strong>Failure' in shown
    assert 'goal 2' in shown.split('</strong>')[0]


def test_a_collision_is_shown_with_its_goal():
    assert verdicts(GOOD, GOOD, GOOD, collision_at=15.0) == ['pass', 'FAIL', 'pass']
    assert 'Failure: made up; 1 collisions' in page(*mission(GOOD, GOOD, GOOD, collision_at=15.0))


def test_a_good_mission_is_shown_as_one():
    shown = page(*mission(GOOD, GOOD, GOOD))
    assert 'class="passed"><strong>Success' in shown
    assert verdicts(GOOD, GOOD, GOOD) == ['pass', 'pass', 'pass']
    assert 'FAIL' not in shown
    assert 'slow 0.2' in shown


def test_the_report_shows_every_picture_that_it_writes(tmp_path):
    shown = write_report(tmp_path, *mission(GOOD, GOOD, GOOD)).read_text()
    assert re.findall('img src="([^"]+)"', shown) == list(PICTURES)
    assert {path.name for path in tmp_path.iterdir()} == {'report.html', *PICTURES}
    assert all(path.read_bytes().startswith(b'\x89PNG') for path in tmp_path.glob('*.png'))


def test_a_mission_without_map_and_without_goals_has_a_report(tmp_path):
    summary, traces = mission(GOOD)
    summary['goals'], summary['orders'] = [], []
    bare = MissionTraces(traces.layout, (), traces.truth, traces.clearance, traces.poses, [])
    assert 'not reached' in write_report(tmp_path, summary, bare).read_text()


@pytest.mark.parametrize('steps', [1, 2, 12])
@pytest.mark.filterwarnings('error::UserWarning')
def test_a_mission_that_broke_off_at_once_has_a_report_with_the_reason(tmp_path, steps):
    summary, whole = mission(GOOD)
    summary['goals'], summary['success'] = [], False
    summary['ended'] = 'vlc_beacon ended with exit code -9'
    nothing = {name: [] for name in ('pose_arbiter', 'odometry', 'vlc_beacon')}
    truth, clearance = whole.truth[:steps], whole.clearance[:steps]
    broken = MissionTraces(whole.layout, whole.boxes, truth, clearance, nothing, [])
    shown = write_report(tmp_path, summary, broken).read_text()
    assert 'Failure: vlc_beacon ended with exit code -9' in shown
    assert shown.count('>FAIL<') == 3


def test_errors_are_those_of_the_time_of_the_pose():
    truth = np.array([[0.0, 0.0, 0.0, 3.1], [1.0, 2.0, 0.0, -3.1]])
    times, off, turn = pose_errors(np.array([[-1.0, 0, 0, 0], [0.5, 1.0, 0.03, math.pi]]), truth)
    assert times.tolist() == [0.5]
    assert off == pytest.approx([0.03])
    assert turn == pytest.approx([0.0], abs=1e-9)


def test_exact_odometry_is_aligned_to_the_truth_from_any_start():
    rng = np.random.default_rng(4)
    truth = [SE2(*rng.uniform(-1, 1, 3).tolist()) for _ in range(9)]
    start = SE2(0.3, -0.2, 2.0) @ truth[0].inverse()
    fused = np.array([[k, p.x, p.y, p.yaw] for k, p in enumerate(start @ pose for pose in truth)])
    real = np.array([[k, p.x, p.y, p.yaw] for k, p in enumerate(truth)])
    assert align_to_map(fused, real)[:, 1:3] == pytest.approx(real[:, 1:3])


def test_zone_spans_are_the_times_inside():
    _, traces = mission(GOOD, GOOD, GOOD)
    ((start, end),) = zone_spans(as_array(traces.truth))['dark']
    assert (start, end) == (pytest.approx(22.0, abs=0.05), pytest.approx(30.0, abs=0.05))


def test_traces_survive_json():
    _, traces = mission(GOOD)
    read = MissionTraces.from_json(traces.as_json())
    assert read.as_json() == traces.as_json()
    assert read.layout.goals[0].distance_to(traces.layout.goals[0]) < 1e-5
    assert (read.trust, read.map and read.map.shape) == (traces.trust, [2, 3])


def test_the_replay_has_every_pose_at_its_time_and_the_status_of_most_poses():
    _, traces = mission(GOOD, GOOD, GOOD)
    data = replay_data(replace(traces, people=[[(time, 1.0)] for time, *_ in traces.truth]))
    assert all(x == pytest.approx(1.0 + 0.2 * t, abs=1e-3) for t, x, _, _ in data['truth'])
    assert np.diff([row[0] for row in data['truth']]) == pytest.approx(0.1, abs=0.021)
    assert [[(row[0], 1.0)] for row in data['truth']] == pytest.approx(np.array(data['people']), abs=0.01)
    assert data['status']['vlc_beacon'][:20] == [*['used'] * 7, 'gated', *['used'] * 11, '']


def test_the_moving_picture_is_a_gif_and_other_files_are_refused_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(moving_picture, '_IMAGES', 3)
    _, traces = mission(GOOD)
    (tmp_path / 'traces.json').write_text(traces.as_json())
    assert picture([str(tmp_path), str(tmp_path / 'a.gif')]) == 0
    assert (tmp_path / 'a.gif').read_bytes().startswith(b'GIF89a')
    for text in ('{', '[]', '{"layout": 1}'):
        (tmp_path / 'traces.json').write_text(text)
        assert picture([str(tmp_path), str(tmp_path / 'b.gif')]) == 1
        assert capsys.readouterr().err.count('\n') == 1
    assert not (tmp_path / 'b.gif').exists()


@pytest.mark.skipif(shutil.which('chromium') is None, reason='the page is tested in chromium: apt-get install chromium')
def test_the_page_replays_fits_a_phone_and_prints_on_two_pages(tmp_path):
    playwright = pytest.importorskip('playwright.sync_api', reason='pip install playwright')
    address = write_report(tmp_path, *mission(GOOD, GOOD, GOOD)).as_uri()
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which('chromium'), args=['--no-sandbox'])
        shown, faults = browser.new_page(viewport={'width': 390, 'height': 844}), []
        shown.on('pageerror', lambda fault: faults.append(str(fault)))
        shown.goto(address)
        shown.get_by_label('Time of the mission').fill('9.5')
        assert shown.locator('#sources .good, #sources .weak').all_inner_texts() == ['used']
        assert shown.evaluate('document.documentElement.scrollWidth') == 390
        assert len(re.findall(rb'/Type /Page\b', shown.pdf(prefer_css_page_size=True))) == 2
        assert faults == []
        browser.close()
