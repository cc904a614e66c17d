"""Parameters of the view."""

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class ViewSettings:
    """Driving by hand, and frames."""

    forward_speed: float = setting(0.3, 'forward speed of the stick at its end', 'm/s', (0.0, 3.0))
    turn_rate: float = setting(0.8, 'turn rate of the stick at its end', 'rad/s', (0.0, 6.0))
    heartbeat_timeout: float = setting(
        0.2, 'the robot stops when the driving page is silent for this long', 's', (0.1, 1.0)
    )
    map_frame: str = setting('map', 'frame of goals and initial poses')
    base_frame: str = setting('base_link', 'frame of velocities')
    stamped: bool = setting(True, 'velocities as TwistStamped; false: Twist')
