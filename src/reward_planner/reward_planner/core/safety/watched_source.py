"""One range sensor of the collision monitor: its freshness, obstacles and their motion."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.safety.cluster_tracker import CellMotion, ClusterTracker, HiddenCells
from reward_planner.core.safety.footprint import Footprint
from reward_planner.core.safety.range_frame import RangeFrame
from reward_planner.core.safety.range_kernels import MOVING, STATIC, UNSURE
from reward_planner.core.safety.range_memory import ObstacleCells, RangeMemory
from reward_planner.core.safety.safety_settings import CollisionMonitorSettings, SourceSettings
from reward_planner.core.safety.stopping_motion import Obstacles
from shirube_core.geometry import SE2, rotation_matrix

_FUTURE_MAX = 0.1  # stamps may be this far ahead of the clock [s]
_UNSEEN_MARGIN = 0.018  # [m]
_GROWTH_TIME = 1.0  # the place of somebody hidden becomes no less certain after this time [s]
_WALK_CHANGE = 0.3  # by how much somebody changes his velocity at once [m/s]


class PredictedObstacles(NamedTuple):
    """All obstacles; those that may turn out to walk, as if they did; the sigma of all speeds, NaN if unknown [m/s].

    ``walks`` are those of clusters in view that moved as a whole, ``in_view`` those hit now, both of shape (n,).
    """

    all: Obstacles
    unsure: Obstacles
    sigma: NDArray[np.float64]
    walks: NDArray[np.bool_]
    in_view: NDArray[np.bool_]


def chosen(obstacles: Obstacles, mask: NDArray[np.bool_]) -> Obstacles:
    """Return some of the obstacles, with a mask of shape (n,)."""
    return Obstacles(
        obstacles.xy[mask],
        obstacles.velocity[mask],
        obstacles.radius[mask],
        obstacles.growth[mask],
        obstacles.is_static[mask],
    )


class WatchedSource:
    """Takes the measurements of one sensor.

    Attributes:
        name: name of the source.
    """

    def __init__(
        self,
        name: str,
        source: SourceSettings,
        exclusion_zones: NDArray[np.float64],
        settings: CollisionMonitorSettings,
    ) -> None:
        """Start without measurements; the boxes, shape (n, 6), hold parts of the robot."""
        self.name, self._source, self._settings = name, source, settings
        self._zones = exclusion_zones
        self._stamp = -math.inf
        self._fault: str | None = 'no message yet; check its driver and topic'
        self.forget_places()

    def forget_places(self) -> None:
        """Forget all obstacles."""
        self._memory = RangeMemory(self._source, self._settings.memory)
        self._tracker = ClusterTracker()
        self._cells, self._motion = self._memory.obstacles(), CellMotion(np.zeros((0, 2)), np.zeros(0))
        self._mapped_count = 0  # of the cells; the others are predicted
        self._walks = np.zeros(0, dtype=np.bool_)  # of the mapped cells: the cluster moved as a whole
        self._met: list[NDArray[np.float64]] = []  # velocities of hidden people who did not go on

    def invalidate(self, fault: str) -> None:
        """Stop the robot until the next valid measurement, for a reason."""
        self._fault = fault

    def fault(self, now: float) -> str | None:
        """Return why the source is invalid now [s], None if it is valid."""
        if self._fault is None and now - self._stamp > self._source.timeout:
            return 'no new message; check its driver and topic'
        return self._fault

    def add(self, stamp: float, now: float, frame: RangeFrame, T_odom_base: SE2 | None) -> None:
        """Take a measurement; arguments and errors as of `CollisionMonitor.add_frame`."""
        self._fault = self._fault_of(stamp, now, frame)
        if self._fault is not None:
            raise RewardPlannerError(f'{self.name}: {self._fault}')
        if T_odom_base is None:
            raise RewardPlannerError(f'{self.name}: the motion at its stamp is unknown; check odom')
        frame = self._without_robot(frame)
        if len(frame.ends) == 0:
            self._fault = 'exclusion_zones hold all of its points; make them as small as the parts of the robot'
            raise RewardPlannerError(f'{self.name}: {self._fault}')
        source, relative = self._source, frame.ends - frame.origin
        distance = np.hypot(relative[:, 0], relative[:, 1])
        used = frame.is_hit & (frame.ends[:, 2] >= source.height_min) & (frame.ends[:, 2] <= source.height_max)
        used &= (distance >= source.range_min) & (distance <= source.range_max)
        self._stamp = stamp
        self._memory.update(stamp, frame, T_odom_base, used)
        self._cells = self._memory.obstacles()
        moves = (self._cells.kind == MOVING) & (self._cells.stamp == stamp)
        motion = self._tracker.update(stamp, self._cells.xy[moves], self._memory.is_open, self._memory.origin[:2])
        velocity, sigma = np.zeros((len(moves), 2)), np.full(len(moves), np.nan)
        velocity[moves], sigma[moves] = motion
        before = (self._cells.kind == MOVING) & ~moves
        velocity[before], sigma[before] = self._tracker.motion_of(self._cells.xy[before])
        # A part of a surface that comes into view looks as if it moved.
        resting = np.flatnonzero(moves)[self._tracker.resting]
        self._cells.kind[resting], velocity[resting], sigma[resting] = STATIC, 0.0, np.nan
        self._walks = np.zeros(len(moves), dtype=np.bool_)
        self._walks[moves] = self._tracker.shifted
        self._append_hidden(CellMotion(velocity, sigma))

    def _append_hidden(self, motion: CellMotion) -> None:
        """Add those who left the field of view."""
        hidden, cells = self._tracker.hidden(), self._cells
        self._met = [each for each in self._met if (hidden.velocity == each).all(axis=1).any()]
        goes_on = np.ones(len(hidden.xy), dtype=np.bool_)
        for each in self._met:
            goes_on &= (hidden.velocity != each).any(axis=1)
        hidden = HiddenCells(*(each[goes_on] for each in hidden))
        self._mapped_count = len(cells.xy)
        kind = np.full(len(hidden.xy), MOVING, dtype=np.int8)
        self._cells = ObstacleCells(
            np.concatenate([cells.xy, hidden.xy]),
            np.concatenate([cells.stamp, hidden.stamp]),
            np.concatenate([cells.kind, kind]),
        )
        self._motion = CellMotion(
            np.concatenate([motion.velocity, hidden.velocity]), np.concatenate([motion.sigma, hidden.sigma])
        )

    def _fault_of(self, stamp: float, now: float, frame: RangeFrame) -> str | None:
        if len(frame.ends) == 0:
            return 'it has no valid range; check the sensor'
        if stamp > now + _FUTURE_MAX:
            return 'its stamp is in the future; synchronize the clocks and set use_sim_time alike'
        if now - stamp > self._source.timeout:
            return 'its stamp is too old; synchronize the clocks or check the network'
        if stamp <= self._stamp:
            return 'it came out of order; give each topic one publisher'
        return None

    def _without_robot(self, frame: RangeFrame) -> RangeFrame:
        """Drop rays that end in an exclusion zone."""
        kept = np.ones(len(frame.ends), dtype=np.bool_)
        for zone in self._zones:
            kept &= ~((frame.ends >= zone[:3]) & (frame.ends <= zone[3:])).all(axis=1)
        return RangeFrame(frame.origin, frame.ends[kept], frame.is_hit[kept])

    def count_inside(self, footprint: Footprint, T_odom_base: SE2) -> int:
        """Return how many cells are seen within the footprint; older ones there are forgotten, predicted ones stay."""
        xy = T_odom_base.inverse().transform(self._cells.xy)
        near = np.flatnonzero(np.hypot(*xy[: self._mapped_count].T) < footprint.radius)
        inside = near[footprint.distances(xy[near]) < 0.0]
        is_seen = self._cells.stamp[inside] == self._stamp
        self._memory.forget(self._cells.xy[inside[~is_seen]])
        return int(is_seen.sum())

    def drop_met(self, now: float, footprint: Footprint, T_odom_base: SE2) -> None:
        """Drop the prediction that hidden people walk on if it brings them into the footprint now [s]: they did not."""
        cells, velocity, count = self._cells, self._motion.velocity, self._mapped_count
        xy = T_odom_base.inverse().transform(cells.xy[count:] + velocity[count:] * (now - cells.stamp[count:, None]))
        near = np.flatnonzero((np.hypot(*xy.T) < footprint.radius) & velocity[count:].any(axis=1))
        inside = near[footprint.distances(xy[near]) < 0.0]
        if len(inside) == 0:
            return
        met = np.unique(velocity[count + inside], axis=0)
        self._met += list(met)
        kept = np.ones(len(cells.xy), dtype=np.bool_)
        kept[count:] = ~(velocity[count:, None] == met).all(axis=2).any(axis=1)
        self._cells = ObstacleCells(cells.xy[kept], cells.stamp[kept], cells.kind[kept])
        self._motion = CellMotion(velocity[kept], self._motion.sigma[kept])

    def obstacles(self, now: float, T_odom_base: SE2) -> PredictedObstacles:
        """Return the predicted obstacles now [s] in the base frame.

        What moves but is not tracked can be anywhere within obstacle_speed times its age; what is tracked is where its
        velocity brings it, within two standard deviations and a change of its walk.
        """
        cells, settings, sigma = self._cells, self._settings, self._motion.sigma
        age, moves = now - cells.stamp, cells.kind == MOVING
        walk = np.nan_to_num(2.0 * sigma + _WALK_CHANGE, nan=np.inf)
        growth = np.where(moves, np.minimum(walk, settings.obstacle_speed), 0.0)
        xy = T_odom_base.inverse().transform(cells.xy + self._motion.velocity * age[:, None])
        velocity = self._motion.velocity @ rotation_matrix(T_odom_base.yaw)
        # What has left the view may be nearer than the part that was seen last.
        margin = settings.stop_margin + _UNSEEN_MARGIN * (cells.stamp < self._stamp)
        # The robot may leave somebody who may stand near it, out of view.
        rests = ~moves | (np.arange(len(xy)) >= self._mapped_count) & ~velocity.any(axis=1)
        known = Obstacles(xy, velocity, margin + growth * np.minimum(age, _GROWTH_TIME), growth, rests)
        # What was seen for a moment only is an obstacle, and may be somebody.
        speed = np.full(len(xy), settings.obstacle_speed)
        walking = Obstacles(xy, velocity, margin + speed * age, speed, np.zeros(len(xy), dtype=np.bool_))
        walks = np.concatenate([self._walks, np.zeros(len(xy) - self._mapped_count, dtype=np.bool_)])
        in_view = cells.stamp == self._stamp
        return PredictedObstacles(known, chosen(walking, cells.kind == UNSURE), sigma, walks, in_view)
