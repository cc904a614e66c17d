"""The diagnostic status of the planner."""

import numpy as np

from reward_planner.core.driving.drive_state import DriveCommand, DriveState
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from reward_planner.interface.planner_output import PlannerReport
from shirube_core.geometry import SE2, CameraMount
from shirube_ros.diagnostics import Level
from shirube_ros.stamps import StampSynchronizer


def a_report(navigator=None, now=lambda: 5.0, groups=None):
    return PlannerReport(navigator or a_navigator(), now, 1.0, groups)


def a_navigator():
    return Navigator(CameraMount((0.0, 0.0, 0.3), (0.0, 0.0, 0.0)), NavigatorSettings())


def test_a_robot_that_is_stopped_by_a_problem_is_a_warning():
    report = a_report()
    assert report.status().level is Level.OK
    for state in DriveState:
        report.add_drive(DriveCommand(state, f'why {state.name}', None))
        status = report.status()
        assert status.message == f'why {state.name}'
        stands = {DriveState.UNREACHABLE, DriveState.LOST, DriveState.MAP_STALE, DriveState.STUCK}
        assert status.level is (Level.WARN if state in stands else Level.OK)


def test_frames_points_and_what_was_dropped_are_counted():
    navigator = a_navigator()
    report = a_report(navigator)
    navigator.add_pose(1.0, SE2(0.0, 0.0, 0.0))
    navigator.add_pose(1.2, SE2(50.0, 0.0, 0.0))
    points = np.array([(0.0, 0.0, 1.0), (np.nan, 0.0, 1.0)], dtype=np.float32)
    for stamp in (1.0, 9.0):
        navigator.add_frame(stamp, 1.0, SensorFrame(points, 0.0))
    for now in (1.1, 9.0):
        for frame in navigator.process_frames(now):
            report.add_frame(frame)
    values = report.status().values
    assert values['frames in the map'] == '1'
    assert values['frames dropped: no pose within pose_wait'] == '1'
    assert values['points not finite'] == '1'
    assert values['poses: the pose jumped; mapping waits until poses are consistent'] == '1'


def test_images_without_partners_are_counted():
    groups = StampSynchronizer(('left', 'right'), 0.0)
    report = a_report(groups=groups)
    groups.put('left', 1.0, None)
    for side in ('left', 'right'):
        groups.put(side, 2.0, None)
    assert report.status().values['images dropped: no others with the same stamp'] == '1'


def test_frames_that_are_late_are_a_warning_whatever_the_robot_does():
    navigator, time = a_navigator(), [0.0]
    report = a_report(navigator, lambda: time[0])
    levels = []
    for now in (0.0, 100.0, 101.0, 101.5):
        time[0] = now
        levels.append(report.status().level)
    assert levels == [Level.OK, Level.OK, Level.OK, Level.WARN]
    assert report.status().message == f'{DriveState.IDLE.value}; no frame mapped for 1.5 s'
    navigator.add_pose(101.5, SE2(0.0, 0.0, 0.0))
    navigator.add_frame(101.5, 101.5, SensorFrame(np.array([(0.0, 0.0, 1.0)], dtype=np.float32), 0.0))
    for frame in navigator.process_frames(101.5):
        report.add_frame(frame)
    assert report.status().level is Level.OK
    time[0] = 3.0
    assert report.status().level is Level.OK


def test_the_camera_whose_images_lack_is_named():
    time = [100.0]
    groups = StampSynchronizer(('left', 'right', 'top'), 0.0)
    report = a_report(now=lambda: time[0], groups=groups)
    report.status()
    time[0] = 105.0
    for side in ('left', 'right'):
        groups.put(side, 2.0, None)
    assert 'no frame mapped for 5.0 s: no images of top;' in report.status().message
    groups.put('top', 2.1, None)
    assert 'the stamps of the images differ' in report.status().message
    for side in ('left', 'right'):
        groups.put(side, 2.1, None)
    assert report.status().message.endswith('for 5.0 s')
