"""Tracks clusters of moving obstacle cells with constant-velocity Kalman filters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
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
_LOST = 0.7  # a track without cluster is dropped after this time [s]
_HIDDEN_TIME = 3.0  # somebody who left the field of view is predicted for this time [s]
_HIDDEN_SHARE = 0.5  # with more of his places in view, somebody is not hidden
_CONFIRMED_TIME, _CONFIRMED_SIGMA = 0.25, 0.7  # age [s] and standard deviation of the speed [m/s]


@dataclass(eq=False)
class _Track:
    """Centre and velocity, shape (4,), their covariance, stamp of the last and first cluster [s], its cells."""

    state: NDArray[np.float64]
    covariance: NDArray[np.float64]
    stamp: float
    begin: float
    offsets: NDArray[np.float64]

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
    """Velocities of clusters from one measurement to the next."""

    def __init__(self) -> None:
        """Start without tracks."""
        self._tracks: list[_Track] = []
        self._hidden: list[_Track] = []

    def update(
        self,
        stamp: float,
        xy_odom: NDArray[np.float64],
        is_open: Callable[[NDArray[np.float64]], NDArray[np.bool_]] = all_open,
    ) -> CellMotion:
        """Return the motion of the moving cells of a measurement, shape (n, 2) [m], in the frame of the odometry.

        ``is_open`` returns at which positions, shape (n, 2) [m], the measurement shows that nobody is there.
        """
        velocity, sigma = np.zeros((len(xy_odom), 2)), np.full(len(xy_odom), np.nan)
        self._tracks = [track for track in self._tracks if stamp - track.stamp < _HIDDEN_TIME]
        free = list(self._tracks)
        for members in _clusters(xy_odom):
            track = self._assign(stamp, xy_odom[members], free)
            if track.is_confirmed:
                velocity[members], sigma[members] = track.state[2:], track.speed_sigma
        # Who is not where the prediction has him, though rays pass there, is lost; he may also have left the view.
        self._hidden = []
        for track in free:
            places = track.predicted(stamp)[0][:2] + track.offsets
            if is_open(places).mean() <= _HIDDEN_SHARE:
                self._hidden += [track] if track.is_confirmed else []
            elif stamp - track.stamp > _LOST:
                self._tracks.remove(track)
        return CellMotion(velocity, sigma)

    def hidden(self) -> HiddenCells:
        """Return the cells of people who left the field of view before the latest measurement."""
        parts = [
            (
                track.state[:2] + track.offsets,
                np.tile([*track.state[2:], track.speed_sigma, track.stamp], (len(track.offsets), 1)),
            )
            for track in self._hidden
        ]
        xy = np.concatenate([np.zeros((0, 2)), *(places for places, _ in parts)])
        more = np.concatenate([np.zeros((0, 4)), *(values for _, values in parts)])
        return HiddenCells(xy, more[:, :2], more[:, 2], more[:, 3])

    def _assign(self, stamp: float, xy: NDArray[np.float64], free: list[_Track]) -> _Track:
        """Update the nearest free track by the cells of a cluster, or begin one."""
        centre = xy.mean(axis=0)
        distances = [float(np.hypot(*(track.predicted(stamp)[0][:2] - centre))) for track in free]
        if distances:
            best = int(np.argmin(distances))
            if distances[best] < _GATE + _GATE_GROWTH * (stamp - free[best].stamp):
                track = free.pop(best)
                track.update(stamp, centre)
                track.offsets = xy - centre
                return track
        covariance = np.diag([_POSITION_SIGMA, _POSITION_SIGMA, _SPEED_SIGMA, _SPEED_SIGMA]) ** 2
        track = _Track(np.array([*centre, 0.0, 0.0]), covariance, stamp, stamp, xy - centre)
        self._tracks.append(track)
        return track


def _clusters(xy: NDArray[np.float64]) -> list[NDArray[np.intp]]:
    """Return the indices of the cells of each cluster."""
    if len(xy) == 0:
        return []
    near = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1)) < _LINK
    count, labels = connected_components(csr_matrix(near), directed=False)
    return [np.flatnonzero(labels == k) for k in range(count)]
