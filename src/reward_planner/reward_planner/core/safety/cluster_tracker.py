"""Tracks clusters of moving obstacle cells with constant-velocity Kalman filters."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

_LINK = 0.45  # cells as near belong to one cluster: both legs of a person [m]
_GATE = 0.4  # distance at which a cluster is the predicted one, and its growth with time [m, m/s]
_GATE_GROWTH = 1.5
_POSITION_SIGMA = 0.08  # standard deviation of a cluster's centre: its visible part changes [m]
_ACCELERATION = 1.0  # standard deviation of the acceleration of people [m/s^2]
_SPEED_SIGMA = 1.0  # standard deviation of the velocity of a new track [m/s]
_RESTING_TIME = 0.5  # a cluster that did not move as a whole for this time rests [s]
_HISTORY = 1.0  # clusters of this time are compared [s]
# Part of the way, and distance [m], that front and back must have moved.
_SHIFT_FRACTION, _SHIFT_MIN = 0.5, 0.1
_JUMP, _SPEED_MAX = 0.1, 2.0  # greatest way of the centre between measurements [m, m/s]
_WALKING = 0.4  # slower clusters may be parts of a surface that come into view [m/s]
_LOST = 0.7  # a track without cluster is dropped after this time [s]
_HIDDEN_TIME = 3.0  # somebody who left the field of view is predicted for this time [s]
_REST_CELL = 0.05  # cells out of view are thinned to one in a square of this side [m]
_HIDDEN_SHARE = 0.5  # with more of his places in view, somebody is not hidden
_CONFIRMED_TIME, _CONFIRMED_SIGMA = 0.25, 0.7  # age [s] and standard deviation of the speed [m/s]


@dataclass(eq=False)
class _Track:
    """Centre and velocity, shape (4,), their covariance, stamp of the last and first cluster [s], last cells."""

    state: NDArray[np.float64]
    covariance: NDArray[np.float64]
    stamp: float
    begin: float
    history: list[tuple[float, NDArray[np.float64]]] = field(default_factory=list)
    has_walked: bool = False  # moved as a whole before; a part that leaves the view hides that later
    # Cells out of view of somebody whose rest is in view: position [m] and stamp when they were seen [s].
    rest: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))

    def remember(self, stamp: float, xy: NDArray[np.float64]) -> None:
        """Keep the cells of the last clusters, shape (n, 2) [m]; one that split, merged or jumped begins anew."""
        self.history = [(then, each) for then, each in self.history if stamp - then < _HISTORY]
        if self.history:
            then, before = self.history[-1]
            if np.hypot(*(xy.mean(axis=0) - before.mean(axis=0))) > _JUMP + _SPEED_MAX * (stamp - then):
                self.history.clear()
        self.history.append((stamp, xy))
        self.has_walked |= self.is_shifted

    def keep_rest(self, stamp: float, is_open: Callable[[NDArray[np.float64]], NDArray[np.bool_]]) -> None:
        """Move the cells of the last clusters to a later stamp, before its own; those in view are dropped."""
        before = np.column_stack([self.places, np.full(len(self.places), self.stamp)])
        rest = np.concatenate([before, self.rest[self.rest[:, 2] > stamp - _HIDDEN_TIME]])
        rest[:, :2] += self.state[2:] * (stamp - self.stamp)
        # One of each place, the latest.
        _, first = np.unique(np.floor(rest[:, :2] / _REST_CELL), axis=0, return_index=True)
        self.rest = rest[first][~is_open(rest[first, :2])]

    @property
    def duration(self) -> float:
        """Time for which the cells were seen without a jump [s]."""
        return self.history[-1][0] - self.history[0][0]

    @property
    def is_shifted(self) -> bool:
        """Whether front and back moved as the centre did: what comes into view grows on one side only."""
        (begin, before), (end, after) = self.history[0], self.history[-1]
        speed = float(np.hypot(*self.state[2:]))
        heading = self.state[2:] / max(speed, 1e-9)
        ways = (edge(after @ heading) - edge(before @ heading) for edge in (np.max, np.min))
        return bool(min(ways) > max(_SHIFT_FRACTION * speed * (end - begin), _SHIFT_MIN))

    def rests(self, origin: NDArray[np.float64] | None) -> bool:
        """Return whether the cluster was there for a while without moving as a whole, or to the sensor at an origin."""
        if self.is_shifted or self.duration < _RESTING_TIME:
            return False
        if origin is None:
            return True
        before, after = (float(np.hypot(*(self.history[k][1] - origin).T).min()) for k in (0, -1))
        return before - after < _SHIFT_MIN

    def predicted(self, stamp: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return state and covariance at a later stamp."""
        dt = stamp - self.stamp
        F = np.eye(4)
        F[0, 2] = F[1, 3] = dt
        G = np.vstack([0.5 * dt * dt * np.eye(2), dt * np.eye(2)])
        return F @ self.state, F @ self.covariance @ F.T + _ACCELERATION**2 * G @ G.T

    def update(self, stamp: float, centre: NDArray[np.float64]) -> None:
        """Kalman update with the centre of a cluster."""
        state, covariance = self.predicted(stamp)
        innovation_covariance = covariance[:2, :2] + _POSITION_SIGMA**2 * np.eye(2)
        gain = np.linalg.solve(innovation_covariance, covariance[:2]).T
        self.state = state + gain @ (centre - state[:2])
        self.covariance = covariance - gain @ covariance[:2]
        self.stamp = stamp

    @property
    def places(self) -> NDArray[np.float64]:
        """Cells of the last cluster, shape (n, 2) [m]."""
        return self.history[-1][1]

    @property
    def is_confirmed(self) -> bool:
        """Whether the velocity is known."""
        return self.stamp - self.begin >= _CONFIRMED_TIME and self.speed_sigma < _CONFIRMED_SIGMA

    @property
    def speed_sigma(self) -> float:
        """Largest standard deviation of the velocity [m/s]."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance[2:, 2:])[-1]))


class CellMotion(NamedTuple):
    """Velocity of each moving cell, shape (n, 2) [m/s], and its standard deviation, shape (n,), NaN if unknown."""

    velocity: NDArray[np.float64]
    sigma: NDArray[np.float64]


class HiddenCells(NamedTuple):
    """Cells of people who left the field of view, where they were seen last: position [m], velocity [m/s], sigma [m/s].

    The arrays have the shapes (n, 2), (n, 2) and (n,); ``stamp`` is when they were seen [s], shape (n,).
    """

    xy: NDArray[np.float64]
    velocity: NDArray[np.float64]
    sigma: NDArray[np.float64]
    stamp: NDArray[np.float64]


def all_open(xy: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return that every position is in view, shape (n,)."""
    return np.ones(len(xy), dtype=np.bool_)


class ClusterTracker:
    """Velocities of clusters from one measurement to the next.

    Attributes:
        labels: number of the cluster of each cell of the latest measurement, shape (n,).
        shifted: whether the cluster moved as a whole, of each cell, shape (n,).
        resting: whether the cluster was there for a while without moving as a whole, of each cell, shape (n,).
    """

    def __init__(self) -> None:
        """Start without tracks."""
        self.labels = np.empty(0, dtype=np.int64)
        self.shifted, self.resting = np.empty(0, dtype=np.bool_), np.empty(0, dtype=np.bool_)
        self._tracks: list[_Track] = []
        self._hidden: list[_Track] = []

    def update(
        self,
        stamp: float,
        xy_odom: NDArray[np.float64],
        is_open: Callable[[NDArray[np.float64]], NDArray[np.bool_]] = all_open,
        origin: NDArray[np.float64] | None = None,
    ) -> CellMotion:
        """Return the motion of the moving cells of a measurement, shape (n, 2) [m], in the frame of the odometry.

        ``is_open`` returns at which positions, shape (n, 2) [m], the measurement shows that nobody is there; the
        sensor is at ``origin``, shape (2,) [m].
        """
        velocity, sigma = np.zeros((len(xy_odom), 2)), np.full(len(xy_odom), np.nan)
        self._tracks = [track for track in self._tracks if stamp - track.stamp < _HIDDEN_TIME]
        free = list(self._tracks)
        self.labels = np.zeros(len(xy_odom), dtype=np.int64)
        self.shifted, self.resting = (np.zeros(len(xy_odom), dtype=np.bool_) for _ in range(2))
        for label, members in enumerate(_clusters(xy_odom)):
            track = self._assign(stamp, xy_odom[members], free, is_open)
            self.labels[members] = label
            self.shifted[members] = track.is_shifted
            self.resting[members] = track.rests(origin)
            if track.is_confirmed:
                velocity[members], sigma[members] = track.state[2:], track.speed_sigma
        # Who is not where the prediction has him, though rays pass there, is lost; he may also have left the view.
        self._hidden = []
        for track in free:
            places = track.places + (track.predicted(stamp)[0] - track.state)[:2]
            if is_open(places).mean() <= _HIDDEN_SHARE:
                self._hidden += [track] if track.is_confirmed and track.has_walked else []
            elif stamp - track.stamp > _LOST:
                self._tracks.remove(track)
        return CellMotion(velocity, sigma)

    def hidden(self) -> HiddenCells:
        """Return the cells of people, or parts of them, that left the view before the latest measurement."""
        outlines = [(each, np.concatenate([each.places, each.rest[:, :2]]), True) for each in self._hidden]
        outlines += [
            (each, each.rest[:, :2], False)
            for each in self._tracks
            if each not in self._hidden and each.is_confirmed and each.has_walked
        ]
        parts = [
            (places, np.tile([*velocity, sigma, each.stamp], (len(places), 1)))
            for each, places, may_stop in outlines
            for velocity, sigma in ((each.state[2:], each.speed_sigma), (np.zeros(2), 0.0))[: 1 + may_stop]
        ]
        xy = np.concatenate([np.zeros((0, 2)), *(places for places, _ in parts)])
        more = np.concatenate([np.zeros((0, 4)), *(values for _, values in parts)])
        return HiddenCells(xy, more[:, :2], more[:, 2], more[:, 3])

    def motion_of(self, xy_odom: NDArray[np.float64]) -> CellMotion:
        """Return the motion of cells of earlier measurements, shape (n, 2) [m]: they went on with somebody's others."""
        velocity, sigma = np.zeros((len(xy_odom), 2)), np.full(len(xy_odom), np.nan)
        for track in self._tracks:
            is_walking = track.is_shifted and float(np.hypot(*track.state[2:])) > _WALKING
            if is_walking and track.is_confirmed and track not in self._hidden:
                held = np.concatenate([xy for _, xy in track.history])
                is_his = (xy_odom[:, None] == held).all(axis=2).any(axis=1)
                velocity[is_his], sigma[is_his] = track.state[2:], track.speed_sigma
        return CellMotion(velocity, sigma)

    def _assign(
        self,
        stamp: float,
        xy: NDArray[np.float64],
        free: list[_Track],
        is_open: Callable[[NDArray[np.float64]], NDArray[np.bool_]],
    ) -> _Track:
        """Update the nearest free track by the cells of a cluster, or begin one."""
        centre = xy.mean(axis=0)
        distances = [float(np.hypot(*(track.predicted(stamp)[0][:2] - centre))) for track in free]
        if distances:
            best = int(np.argmin(distances))
            if distances[best] < _GATE + _GATE_GROWTH * (stamp - free[best].stamp):
                track = free.pop(best)
                track.keep_rest(stamp, is_open)
                track.update(stamp, centre)
                track.remember(stamp, xy)
                return track
        covariance = np.diag([_POSITION_SIGMA, _POSITION_SIGMA, _SPEED_SIGMA, _SPEED_SIGMA]) ** 2
        track = _Track(np.array([*centre, 0.0, 0.0]), covariance, stamp, stamp)
        track.remember(stamp, xy)
        self._tracks.append(track)
        return track


def _clusters(xy: NDArray[np.float64]) -> list[NDArray[np.intp]]:
    """Return the indices of the cells of each cluster."""
    if len(xy) == 0:
        return []
    near = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1)) < _LINK
    count, labels = connected_components(csr_matrix(near), directed=False)
    return [np.flatnonzero(labels == k) for k in range(count)]
