"""The collision monitor stops before contact, names what is invalid, and does not stop for what is beside its way."""

import math

import numpy as np
import pytest

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.safety.collision_monitor import Action, CollisionMonitor
from reward_planner.core.safety.range_frame import depth_rays, range_frame
from reward_planner.core.safety.safety_settings import CollisionMonitorSettings, SourceSettings
from reward_planner.core.safety.stopping_motion import STEP, BaseDynamics, BaseMotion, stopping_path
from scene_simulator.mission.pedestrians import Walker
from scene_simulator.room.box_room import BoxRoom, Solids, cast_rays
from shirube_core.geometry import SE2, PinholeCamera, matrix_from_rpy

ANGLES = np.linspace(-1.0, 1.0, 240)
BEAMS = np.column_stack([np.cos(ANGLES), np.sin(ANGLES), 0.0 * ANGLES])
ORIGIN = np.array([0.1, 0.0, 0.3])
MAST = np.array([0.1, 0.0, 1.2])
HALL = BoxRoom((-8.0, -8.0, 0.0, 8.0, 8.0, 3.0))
SCAN = SourceSettings(type='scan')


class Drive:
    """A robot with a scanner at 10 Hz and a base with a latency of 0.05 s, in simulated time."""

    beams, origin = BEAMS, ORIGIN

    def __init__(self, room=HALL, deceleration=1.0, frame_every=2, **settings):
        self.room, self.now, self.pose, self.speed = room, 100.0, SE2(0.0, 0.0, 0.0), 0.0
        self.given = [(0.0, 0.0)]
        self.deceleration, self.frame_every = deceleration, frame_every
        given = {'deceleration': deceleration, 'latency': 0.05} | settings
        self.monitor = CollisionMonitor(CollisionMonitorSettings(**given), {'scan': SCAN})

    def send(self, walker=None):
        solids = walker.solids_at(self.now - 100.0) if walker else Solids()
        turn = matrix_from_rpy((0.0, 0.0, self.pose.yaw))
        origin = turn @ self.origin + (self.pose.x, self.pose.y, 0.0)
        ends = self.beams * cast_rays(self.room, solids, origin, self.beams @ turn.T)[:, None]
        frame = range_frame(ends.astype(np.float32), np.ones(len(ends), bool), np.eye(3), self.origin)
        self.monitor.add_frame('scan', self.now, self.now, frame)

    def run(self, seconds, walker=None, command=(0.5, 0.0), monitored=True, until=lambda: False):
        decision = None
        for k in range(round(seconds / 0.05)):
            if k % self.frame_every == 0:
                self.send(walker)
            self.monitor.add_command(self.now, *command)
            decision = self.monitor.decide(self.now)
            self.given.append((decision.forward, decision.turn_rate) if monitored else command)
            aim, turn_rate = self.given[-2]
            change = self.deceleration * 0.05
            self.speed += min(max(aim - self.speed, -change), change)
            self.pose = self.pose @ SE2.exp(self.speed * 0.05, 0.0, turn_rate * 0.05)
            self.now += 0.05
            if until():
                break
        return decision

    def gap(self, walker):
        return walker.solids_at(self.now - 100.0).clearance(self.pose.x, self.pose.y, 0.2, 0.6)


def drive_until_contact(speed, *, monitored, kind='person'):
    walker, drive = Walker(kind, SE2(4.0, 0.05, math.pi), speed), Drive()
    drive.run(8.0, walker, monitored=monitored, until=lambda: drive.gap(walker) <= 0.0)
    assert drive.gap(walker) <= 0.0
    return drive


@pytest.mark.parametrize('kind', ['person', 'legs', 'wheelchair'])
def test_somebody_who_walks_head_on_meets_a_standing_robot(kind):
    assert drive_until_contact(1.0, monitored=False, kind=kind).speed == pytest.approx(0.5)
    assert drive_until_contact(1.0, monitored=True, kind=kind).speed < 1e-6


def test_the_stopping_path_is_the_stopping_distance():
    v, a, hold, latency = 0.5, 1.0, 0.05, 0.1
    path = stopping_path(BaseMotion(v, 0.0, v, 0.0), v, 0.0, hold, BaseDynamics(latency, a, 3.0))
    assert path[-1, 0] == pytest.approx(v * (latency + hold) + v**2 / (2.0 * a), abs=1e-9)
    assert len(path) * STEP == pytest.approx(latency + hold + v / a, abs=2 * STEP)
    arc = stopping_path(BaseMotion(0.0, 0.0, 0.0, 0.0), 0.4, 0.8, 2.0, BaseDynamics(0.0, 1e3, 1e3))
    mirrored = stopping_path(BaseMotion(0.0, 0.0, 0.0, 0.0), 0.4, -0.8, 2.0, BaseDynamics(0.0, 1e3, 1e3))
    np.testing.assert_allclose(arc * (1, -1, -1), mirrored, atol=1e-12)


def test_it_stops_before_a_wall_and_leaves_it_again():
    drive = Drive(BoxRoom(HALL.size, ((2.0, -2.0, 0.0, 2.3, 2.0, 1.0),)))
    decision = drive.run(8.0)
    assert decision.action is Action.STOP
    assert decision.source == 'scan'
    assert 0.03 < 2.0 - drive.pose.x - 0.2 < 0.15
    x = drive.pose.x
    assert drive.run(2.0, command=(-0.3, 0.0)).action is not Action.STOP
    assert drive.pose.x < x - 0.2


@pytest.mark.parametrize(('footprint', 'turns'), [((), True), ((0.2, 0.2, -0.4, 0.2, -0.4, -0.2, 0.2, -0.2), False)])
def test_a_round_robot_may_turn_away_from_somebody_who_is_near(footprint, turns):
    drive = Drive(footprint=footprint)
    decision = drive.run(2.0, Walker('person', SE2(0.8, 0.0, math.pi), 0.3), command=(0.0, 0.6))
    assert (decision.turn_rate == 0.6) is turns


def test_the_first_measurement_of_an_obstacle_stops_the_robot():
    drive = Drive()
    drive.run(1.5)
    assert drive.speed == pytest.approx(0.5)
    x = drive.pose.x + 0.42
    drive.room = BoxRoom(HALL.size, ((x, -0.3, 0.0, x + 0.1, 0.3, 1.0),))
    drive.now += 0.01
    drive.send()
    assert drive.monitor.decide(drive.now).forward == 0.0


def test_walls_beside_the_way_do_not_slow_it_and_narrow_ones_do():
    for gap, action in ((0.2, Action.DRIVE), (0.07, Action.SLOW_DOWN)):
        y = 0.2 + gap
        walls = ((0.5, y, 0.0, 7.0, y + 0.2, 1.0), (0.5, -y - 0.2, 0.0, 7.0, -y, 1.0))
        assert Drive(BoxRoom(HALL.size, walls)).run(4.0).action is action


def test_the_footprint_decides_and_an_obstacle_inside_it_is_noticed_at_once():
    """Nav2's issue 4355: the shape at time step 0 counts, however fast the robot is."""
    box = BoxRoom(HALL.size, ((0.62, 0.25, 0.0, 0.7, 0.3, 1.0),))
    long = (0.5, 0.3, -0.5, 0.3, -0.5, -0.3, 0.5, -0.3)
    for footprint, passes in (((), True), (long, False)):
        drive = Drive(box, footprint=footprint)
        drive.run(3.0)
        assert (drive.pose.x > 0.5) is passes
    inside = Drive(BoxRoom(HALL.size, ((0.3, -0.1, 0.0, 0.4, 0.1, 1.0),)), footprint=long)
    decision = inside.run(1.0, command=(2.0, 0.0))
    assert 'within the footprint' in decision.reason
    assert inside.pose.x == 0.0
    zones = (0.2, -0.3, 0.0, 0.5, 0.3, 1.0)
    excluded = Drive(inside.room, footprint=long, exclusion_zones=zones)
    assert excluded.run(1.0).action is Action.DRIVE


def test_what_is_missing_or_old_is_named_and_the_robot_stops():
    drive = Drive()
    assert drive.monitor.decide(drive.now).reason.startswith('scan: no message yet')
    drive.run(1.0)
    drive.now += 0.6
    drive.monitor.add_command(drive.now, 0.5, 0.0)
    silent = drive.monitor.decide(drive.now)
    assert (silent.forward, silent.reason[:21]) == (0.0, 'scan: no new message;')
    drive.run(1.0)
    drive.now += 0.6
    drive.send()
    assert drive.monitor.decide(drive.now).reason.startswith('cmd_vel_in is silent')
    drive.now += 0.05
    drive.run(1.0)
    assert drive.speed > 0.4
    assert 'clock went back' in drive.monitor.decide(drive.now - 5.0).reason


def test_bad_input_is_one_line_and_stops_the_robot():
    drive = Drive()
    drive.run(0.5)
    nothing = range_frame(np.full((4, 3), np.nan, np.float32), np.ones(4, bool), np.eye(3), ORIGIN)
    good = range_frame(np.ones((4, 3), np.float32), np.ones(4, bool), np.eye(3), ORIGIN)
    for frame, stamp, text in (
        (nothing, 0.0, 'no valid range'),
        (good, 1.0, 'in the future'),
        (good, -2.0, 'too old'),
        (good, -0.3, 'out of order'),
    ):
        with pytest.raises(RewardPlannerError, match=text) as raised:
            drive.monitor.add_frame('scan', drive.now + stamp, drive.now, frame)
        assert '\n' not in str(raised.value)
        assert drive.monitor.decide(drive.now).forward == 0.0
    drive.run(0.5)
    with pytest.raises(RewardPlannerError, match='not finite'):
        drive.monitor.add_command(drive.now, math.nan, 0.0)
    assert drive.monitor.decide(drive.now).action is Action.FAULT


@pytest.mark.parametrize(
    ('settings', 'source', 'text'),
    [
        ({'footprint': (0.1, 0.1, 0.2)}, {}, 'three or more corners'),
        ({'footprint': (0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0)}, {}, 'edges cross'),
        ({'exclusion_zones': (0.0, 1.0)}, {}, 'six numbers'),
        ({'exclusion_zones': (0.0, 0.0, 1.0, 1.0, 1.0, 0.0)}, {}, 'lowest corner'),
        ({}, {'height_min': 1.0, 'height_max': 0.5}, 'height_min is not below'),
        ({}, {'range_min': 2.0, 'range_max': 1.0}, 'range_min is not below'),
        ({}, {'rpy': (0.0, 1.0)}, 'rpy has 2 numbers'),
    ],
)
def test_contradictory_limits_are_refused(settings, source, text):
    with pytest.raises(RewardPlannerError, match=text):
        CollisionMonitor(CollisionMonitorSettings(**settings), {'front': SourceSettings(**source)})


def test_an_obstacle_too_low_to_be_seen_is_not_forgotten_and_one_that_leaves_is():
    drive = Drive()
    for present in (True, False):
        drive.room = BoxRoom(HALL.size, ((0.45, -0.3, 0.0, 0.6, 0.3, 1.0),) if present else ())
        decision = drive.run(1.5, command=(0.1, 0.0))
        assert (decision.forward < 0.1) is present
    # Rays above an obstacle show nothing of it.
    drive = Drive(BoxRoom(HALL.size, ((0.75, -0.3, 0.0, 0.9, 0.3, 1.0),)))
    drive.run(1.0, command=(0.0, 0.0))
    above = BEAMS * 6.0 + (0.0, 0.0, 3.0)
    for _ in range(20):
        drive.now += 0.05
        frame = range_frame(above.astype(np.float32), np.ones(240, bool), np.eye(3), ORIGIN)
        drive.monitor.add_frame('scan', drive.now, drive.now, frame)
        drive.monitor.add_command(drive.now, 1.0, 0.0)
        assert drive.monitor.decide(drive.now).fraction < 1.0


def test_depth_images_follow_rep_118():
    camera = PinholeCamera(4, 1, 2.0, 2.0, 1.5, 0.0)
    ends, is_hit = depth_rays(np.array([[2.0, np.inf, -np.inf, np.nan]], np.float32), camera, (0.1, 4.0))
    np.testing.assert_allclose(ends[:, 2], [2.0, 4.0, 0.1, np.nan], rtol=1e-6)
    assert is_hit.tolist()[:3] == [True, False, True]
    with pytest.raises(RewardPlannerError, match='camera_info 4 x 1'):
        depth_rays(np.ones((2, 2), np.float32), camera, (0.1, 4.0))


@pytest.mark.parametrize('seconds', [0.0, 1.5])
def test_a_slow_person_who_first_stands_still_meets_a_standing_robot(seconds):
    """Each frame's hits touch those of the last: yet somebody comes."""
    drive, begin = Drive(frame_every=1), SE2(2.2, 0.03, math.pi)

    class Starts(Walker):
        def pose_at(self, time):
            return super().pose_at(max(0.0, time - seconds))

    walker = Starts('person', begin, 0.33)
    drive.run(8.0, walker, command=(0.36, 0.0), until=lambda: drive.gap(walker) <= 0.0)
    assert drive.speed < 1e-6


def test_somebody_beside_the_robot_who_left_the_view_is_waited_for():
    walker, drive = Walker('person', SE2(3.0, 0.75, -2.95), 1.0), Drive()
    drive.run(8.0, walker, until=lambda: drive.now > 102.6)
    assert drive.speed == 0.0
    drive.run(0.4, walker)
    assert drive.speed == 0.0


def test_it_waits_for_somebody_whose_way_it_would_cross():
    """It stops while there is still room for both, rather than at the edge of the other's way."""
    walker, drive, gaps = Walker('person', SE2(1.9, -2.6, 0.5 * math.pi), 0.9), Drive(), list[float]()
    drive.run(10.0, walker, until=lambda: gaps.append(drive.gap(walker)))
    assert min(gaps) > 0.15
    assert drive.pose.x > 2.0


def test_it_drives_slowly_and_does_not_start_while_it_is_not_certain_where_somebody_walks():
    """Legs do not move as a whole."""
    walker, drive = Walker('legs', SE2(6.0, 0.05, math.pi), 1.0), Drive()
    assert drive.run(8.0, walker, until=lambda: drive.gap(walker) < 2.3).fraction == 0.5
    walker, drive = Walker('legs', SE2(3.2, 0.05, math.pi), 1.2), Drive()
    drive.run(0.8, walker, command=(0.0, 0.0))
    assert drive.run(0.6, walker).action is Action.YIELD
    assert drive.pose.x == 0.0


def test_it_stands_long_before_somebody_who_comes_at_it():
    """Each step towards him would bring it farther into his way."""
    walker, drive = Walker('person', SE2(4.0, 0.05, math.pi), 0.6), Drive()
    decision = drive.run(8.0, walker, until=lambda: drive.gap(walker) < 1.0)
    assert (drive.speed, decision.action) == (0.0, Action.YIELD)


def test_a_zone_that_covers_all_points_stops_the_robot_in_one_line():
    drive = Drive(exclusion_zones=(-20.0, -20.0, -1.0, 20.0, 20.0, 5.0))
    with pytest.raises(RewardPlannerError, match='scan: exclusion_zones hold all of its points'):
        drive.send()
    drive.monitor.add_command(drive.now, 0.5, 0.0)
    decision = drive.monitor.decide(drive.now)
    assert (decision.forward, decision.action) == (0.0, Action.FAULT)
