"""Tracks clusters of moving obstacle cells with constant-velocity Kalman filters."""

from __future__ import annotations

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
_HISTORY = 1.0  # clusters of this time are compared [s]
_SHIFT_FRACTION, _SHIFT_MIN = (
    0.5,
    0.1,
)  # part of the way, and distance [m], that front and back must have moved
_JUMP, _SPEED_MAX = 0.1, 2.0  # greatest way of the centre between measurements [m, m/s]
_LOST = 0.7  # a track without cluster is dropped after this time [s]
_CONFIRMED_TIME, _CONFIRMED_SIGMA = 0.25, 0.7  # age [s] and standard deviation of the speed [m/s]


@dataclass
class _Track:
    """Centre and velocity, shape (4,), their covariance, stamp of the last and first cluster [s]."""

    state: NDArray[np.float64]
    covariance: NDArray[np.float64]
    stamp: float
    begin: float
    history: list[tuple[float, NDArray[np.float64]]] = field(default_factory=list)

    def remember(self, stamp: float, xy: NDArray[np.float64]) -> None:
        """Keep the cells of the last clusters, shape (n, 2) [m]; one that split, merged or jumped begins anew."""
        self.history = [(then, each) for then, each in self.history if stamp - then < _HISTORY]
        if self.history:
            then, before = self.history[-1]
            if np.hypot(*(xy.mean(axis=0) - before.mean(axis=0))) > _JUMP + _SPEED_MAX * (stamp - then):
                self.history.clear()
        self.history.append((stamp, xy))

    def has_shifted(self) -> bool:
        """Return whether front and back moved as the centre did: what comes into view grows on one side only."""
        (begin, before), (end, after) = self.history[0], self.history[-1]
        speed = float(np.hypot(*self.state[2:]))
        heading = self.state[2:] / max(speed, 1e-9)
        ways = (edge(after @ heading) - edge(before @ heading) for edge in (np.max, np.min))
        return bool(min(ways) > max(_SHIFT_FRACTION * speed * (end - begin), _SHIFT_MIN))

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
    def speed_sigma(self) -> float:
        """Largest standard deviation of the velocity [m/s]."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance[2:, 2:])[-1]))


class CellMotion(NamedTuple):
    """Velocity of each moving cell, shape (n, 2) [m/s], and its standard deviation, shape (n,), NaN if unknown."""

    velocity: NDArray[np.float64]
    sigma: NDArray[np.float64]


class ClusterTracker:
    """Velocities of clusters from one measurement to the next.

    Attributes:
        labels: number of the cluster of each cell of the latest measurement, shape (n,).
        shifted: whether the cluster moved as a whole, of each cell, shape (n,).
    """

    def __init__(self) -> None:
        """Start without tracks."""
        self.labels, self.shifted = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.bool_)
        self._tracks: list[_Track] = []

    def update(self, stamp: float, xy_odom: NDArray[np.float64]) -> CellMotion:
        """Return the motion of the moving cells of a measurement, shape (n, 2) [m], in the frame of the odometry."""
        velocity, sigma = np.zeros((len(xy_odom), 2)), np.full(len(xy_odom), np.nan)
        free = [track for track in self._tracks if stamp - track.stamp < _LOST]
        self._tracks = list(free)
        self.labels, self.shifted = (
            np.zeros(len(xy_odom), dtype=np.int64),
            np.zeros(len(xy_odom), dtype=np.bool_),
        )
        for label, members in enumerate(_clusters(xy_odom)):
            self.labels[members] = label
            track = self._assign(stamp, xy_odom[members].mean(axis=0), free)
            track.remember(stamp, xy_odom[members])
            self.shifted[members] = track.has_shifted()
            if stamp - track.begin >= _CONFIRMED_TIME and track.speed_sigma < _CONFIRMED_SIGMA:
                velocity[members], sigma[members] = track.state[2:], track.speed_sigma
        return CellMotion(velocity, sigma)

    def _assign(self, stamp: float, centre: NDArray[np.float64], free: list[_Track]) -> _Track:
        """Update the nearest free track, or begin one."""
        distances = [float(np.hypot(*(track.predicted(stamp)[0][:2] - centre))) for track in free]
        if distances:
            best = int(np.argmin(distances))
            if distances[best] < _GATE + _GATE_GROWTH * (stamp - free[best].stamp):
                track = free.pop(best)
                track.update(stamp, centre)
                return track
        covariance = np.diag([_POSITION_SIGMA, _POSITION_SIGMA, _SPEED_SIGMA, _SPEED_SIGMA]) ** 2
        track = _Track(np.array([*centre, 0.0, 0.0]), covariance, stamp, stamp)
        self._tracks.append(track)
        return track


def _clusters(xy: NDArray[np.float64]) -> list[NDArray[np.intp]]:
    """Return the indices of the cells of each cluster."""
    if len(xy) == 0:
        return []
    near = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1)) < _LINK
    count, labels = connected_components(csr_matrix(near), directed=False)
    return [np.flatnonzero(labels == k) for k in range(count)]
