"""Pose measurements, their status after outlier rejection, and reasons to reject a message before."""

from enum import Enum
from typing import NamedTuple

from pose_arbiter.core.kalman_filter import Covariance
from shirube_core.geometry import SE2


class MeasurementStatus(Enum):
    """Result of outlier rejection for one pose; the value is the text of the diagnostics."""

    USED = 'used'
    RESET = 'estimate reset to it'
    WAITING = 'waiting for a second source at start'
    OUTSIDE_GATE = 'outside the gate'
    PROBATION = 'inside the gate again, on probation'
    ODOMETRY_INCONSISTENT = 'inconsistent with odometry'


class RejectReason(Enum):
    """Why a message is rejected before the filter; the value is the text of the diagnostics."""

    NOT_FINITE = 'not finite'
    TOO_FAR = 'farther than 1000 km from the origin'
    BAD_COVARIANCE = 'covariance is invalid'
    NO_STAMP = 'stamp is 0'
    FUTURE = 'stamp is in the future'
    TOO_OLD = 'stamp is too old'
    DUPLICATE = 'duplicate stamp'


class PoseMeasurement(NamedTuple):
    """A measured pose. Measurements are processed in the sort order of this tuple.

    Attributes:
        stamp: stamp [ns].
        source: source index; -1 is a pose set by an operator.
        pose: ``T_map_base``.
        noise: covariance R of the measurement.
    """

    stamp: int
    source: int
    pose: SE2
    noise: Covariance
