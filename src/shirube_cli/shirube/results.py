"""What the library returns: small records with a pose, or with the reason for none."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2


@dataclass(frozen=True)
class Result:
    """A pose of the robot, or the reason for none.

    Attributes:
        pose: x, y [m] and yaw [rad] of the robot in the map; None without a pose.
        covariance: covariance of x, y [m] and yaw [rad], shape (3, 3); None without a pose.
        reason: why there is no pose; None with one.
    """

    pose: tuple[float, float, float] | None = None
    covariance: NDArray[np.float64] | None = None
    reason: str | None = None

    def __bool__(self) -> bool:
        """Return whether there is a pose."""
        return self.pose is not None


@dataclass(frozen=True)
class LampResult(Result):
    """A pose from lamps, or the reason for none.

    Attributes:
        lamps: u, v [px] of each identified lamp in the last image, by its ID.
    """

    lamps: dict[int, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class PlaceResult(Result):
    """A pose at a taught place, or the reason for none.

    Attributes:
        place: name of the recognized place, empty without a pose.
    """

    place: str = ''


@dataclass(frozen=True)
class FusedResult(Result):
    """The fused pose at the last stamp, or the reason for none.

    Attributes:
        counts: number of poses by source and outcome.
    """

    counts: dict[str, dict[str, int]] = field(default_factory=dict)


@dataclass(frozen=True)
class RouteResult:
    """A route, or the reason for none.

    Attributes:
        cells: rows and columns from start to goal; empty without a route.
        length: its length [cells]; 0 without a route.
        reason: why there is no route; None with one.
    """

    cells: list[tuple[int, int]] = field(default_factory=list)
    length: float = 0.0
    reason: str | None = None


def as_pose(pose: SE2) -> tuple[float, float, float]:
    """Return x, y [m] and yaw [rad]."""
    return float(pose.x), float(pose.y), float(pose.yaw)
