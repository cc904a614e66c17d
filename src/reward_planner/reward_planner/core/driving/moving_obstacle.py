"""An obstacle that moves: what the tracker of the map hands to the drive controller."""

from dataclasses import dataclass


@dataclass(frozen=True)
class MovingObstacle:
    """A tracked cluster of points in the map frame, with constant velocity.

    Attributes:
        stamp: time of the position [s].
        position: centre (x, y) [m].
        velocity: (x, y) [m/s].
        radius: radius of the disc that holds the cluster [m].
    """

    stamp: float
    position: tuple[float, float]
    velocity: tuple[float, float]
    radius: float

    def position_at(self, time: float) -> tuple[float, float]:
        """Return the predicted centre (x, y) at a time [s], in meters."""
        elapsed = time - self.stamp
        return self.position[0] + elapsed * self.velocity[0], self.position[1] + elapsed * self.velocity[1]
