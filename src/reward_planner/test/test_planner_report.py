"""What the diagnostics say at a glance."""

import numpy as np

from reward_planner.core.driving.drive import Drive, DriveState
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from reward_planner.planner_report import PlannerReport
from shirube_geometry import CameraMount, PlanarPose
from shirube_ros.diagnostics import Level
from shirube_ros.stamp_groups import StampGroups


def a_navigator():
    return Navigator(CameraMount((0.0, 0.0, 0.3), (0.0, 0.0, 0.0)), NavigatorSettings())


def test_a_robot_that_stands_although_it_should_not_is_a_warning():
    report = PlannerReport(a_navigator())
    assert report.status().level is Level.OK
    for state in DriveState:
        report.add_drive(Drive(state, f'why {state.name}', None))
        status = report.status()
        assert status.message == f'why {state.name}'
        stands = {DriveState.UNREACHABLE, DriveState.LOST, DriveState.BLIND, DriveState.STUCK}
        assert status.level is (Level.WARN if state in stands else Level.OK)


def test_frames_points_and_what_was_dropped_are_counted():
    navigator = a_navigator()
    report = PlannerReport(navigator)
    navigator.add_pose(1.0, PlanarPose(0.0, 0.0, 0.0))
    navigator.add_pose(1.2, PlanarPose(50.0, 0.0, 0.0))
    points = np.array([(0.0, 0.0, 1.0), (np.nan, 0.0, 1.0)], dtype=np.float32)
    for stamp in (1.0, 9.0):
        navigator.add_frame(stamp, 1.0, SensorFrame(points, 0.0))
    for now in (1.1, 9.0):
        for frame in navigator.work(now):
            report.add_frame(frame)
    values = report.status().values
    assert values['frames in the map'] == '1'
    assert values['frames dropped: its pose did not come in time'] == '1'
    assert values['points not finite'] == '1'
    assert values['poses: the pose jumped; the map waits until poses agree'] == '1'


def test_images_without_partners_are_counted():
    groups = StampGroups(('left', 'right'), 0.0)
    report = PlannerReport(a_navigator())
    report.watch(groups)
    groups.put('left', 1.0, None)
    for side in ('left', 'right'):
        groups.put(side, 2.0, None)
    assert report.status().values['images dropped: others of their time did not come'] == '1'
