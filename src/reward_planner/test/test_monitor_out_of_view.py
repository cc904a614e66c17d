"""What the collision monitor remembers of places that it does not see: people, and noise before walls."""

import numpy as np
import pytest
from test_collision_monitor import BEAMS, HALL, MAST, ORIGIN, SCAN, Drive

from reward_planner.core.safety.range_frame import RangeFrame
from reward_planner.core.safety.range_memory import RangeMemory
from scene_simulator.mission.pedestrians import Walker
from scene_simulator.room.box_room import BoxRoom
from shirube_core.geometry import SE2


@pytest.mark.parametrize('seconds', [0.1, 1.0])
def test_noise_before_a_wall_is_forgotten_and_what_hangs_there_is_kept(seconds):
    """A near camera sees the wall again, but only lower than what it saw from afar."""
    memory, where, none = RangeMemory(SCAN, 600.0), SE2(0.0, 0.0, 0.0), np.zeros(1, bool)
    wall = np.stack(np.meshgrid(1.5, np.linspace(-0.3, 0.3, 61), np.linspace(0.1, 0.5, 21)), axis=-1).reshape(-1, 3)
    high = np.stack(np.meshgrid(1.38, np.linspace(-0.05, 0.05, 5), [1.0, 1.1]), axis=-1).reshape(-1, 3)
    for k in range(40):
        ends = np.concatenate([wall, high]) if 0.1 * k < seconds else wall
        memory.update(0.1 * k, RangeFrame(ORIGIN, ends, np.ones(len(ends), bool)), where, np.ones(len(ends), bool))
    assert (memory.obstacles().xy[:, 0] < 1.45).any() == (seconds == 1.0)
    for k in range(60):  # it drives on and looks elsewhere, and odometry drifts
        memory.update(4.0 + 0.1 * k, RangeFrame(ORIGIN, -wall[:1], none), SE2(0.05 * k, 0.0, 0.0), none)
        assert (memory.obstacles().xy[:, 0] < 1.45).any() == (seconds == 1.0 and k <= 41) or 38 < k < 44


UP = np.stack([np.zeros(40), np.zeros(40), np.linspace(-0.7, 0.3, 40)], axis=1)


class WithCamera(Drive):
    """A robot with a camera of rays up and down, at the height of a mast."""

    beams, origin = (BEAMS[:, None] + UP).reshape(-1, 3), MAST

    def send(self, walker=None):
        self.monitor.add_odometry(self.now, self.pose)
        super().send(walker)


def test_who_is_predicted_within_the_footprint_is_no_wrong_mount():
    drive, walker = WithCamera(), Walker('person', SE2(2.2, 0.95, -2.9), 1.0)
    drive.run(1.6, walker, command=(0.0, 0.0))
    reasons = [drive.run(0.1, walker, command=(0.0, 1.0)).reason for _ in range(25)]
    assert not any('within the footprint' in reason for reason in reasons)


class Stops(Walker):
    """Somebody who stops beside the robot."""

    def pose_at(self, time):
        return super().pose_at(min(time, 1.6))


def test_the_robot_leaves_somebody_who_stopped_beside_it_out_of_view():
    """He did not walk on through the robot, and where he may stand the robot comes no nearer."""
    drive, walker = WithCamera(), Stops('person', SE2(2.2, 0.9, -2.9), 1.0)
    drive.run(1.6, walker, command=(0.0, 0.0))
    drive.run(1.0, walker, command=(0.0, -1.5))
    drive.run(1.0, walker, command=(0.3, 0.0))
    assert drive.speed > 0.2


def test_who_came_and_stood_is_forgotten_out_of_view_and_furniture_is_not():
    place, box = Stops('person', SE2(2.2, 0.9, -2.9), 1.0).pose_at(2.0), (0.2, -0.8, 0.0, 0.5, -0.6, 1.0)
    drive, walker = WithCamera(BoxRoom(HALL.size, (box,))), Stops('person', SE2(2.2, 0.9, -2.9), 1.0)

    def count(x, y):
        xy = drive.monitor.sources['scan']._memory.obstacles().xy
        return (np.hypot(*(xy - (x, y)).T) < 0.4).sum()

    drive.run(5.0, walker, command=(0.0, 0.0))
    drive.run(2.0, walker, command=(0.0, 1.5))
    assert count(place.x, place.y) > 0
    drive.run(10.0, walker, command=(0.0, 0.0))
    assert count(place.x, place.y) == 0 < count(0.35, -0.7)
