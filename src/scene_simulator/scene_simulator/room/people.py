"""People who walk at constant speed, what they push, and the test bodies of driverless trucks."""

from dataclasses import dataclass

from scene_simulator.errors import SceneError
from scene_simulator.room.solids import Cylinder, Solids
from shirube_core.geometry import SE2

KINDS = ('person', 'legs', 'child', 'group', 'wheelchair', 'trolley', 'lying body', 'standing body')
"""What a `Walker` can be; the two test bodies are 200 mm x 600 mm and 70 mm x 400 mm."""
_LEG_OFFSET, _LEG_RADIUS, _LEG_HEIGHT = 0.1, 0.06, 0.85
_GROUP = ((0.0, 0.0), (-0.3, 0.6), (-0.1, -0.6))
"""Places of three people who walk together, along and across their way [m]."""
_UPRIGHT = {
    'person': (_GROUP[:1], 0.22, 1.75),
    'group': (_GROUP, 0.22, 1.75),
    'child': (_GROUP[:1], 0.12, 0.9),
    'standing body': (_GROUP[:1], 0.035, 0.4),
}
"""Places, radius and height of upright bodies [m]."""


@dataclass(frozen=True)
class Walker:
    """Somebody who walks straight on, whatever is in the way.

    Attributes:
        kind: one of `KINDS`.
        start: pose at time 0, the way is along x.
        speed: walking speed [m/s].

    Raises:
        SceneError: an unknown kind.
    """

    kind: str
    start: SE2
    speed: float

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise SceneError(f'{self.kind!r} does not walk here; give one of {", ".join(KINDS)}')

    def pose_at(self, time: float) -> SE2:
        """Return the pose at a time [s]."""
        return self.start @ SE2(self.speed * time, 0.0, 0.0)

    def solids_at(self, time: float) -> Solids:
        """Return the body at a time [s]."""
        pose = self.pose_at(time)
        if self.kind == 'legs':
            return self._legs(pose, time)
        if self.kind == 'trolley':
            pushed = Solids(boxes=((pose.x, pose.y, pose.yaw, 0.4, 0.25, 0.1, 0.95),))
            return pushed + self._legs(pose @ SE2(-0.75, 0.0, 0.0), time)
        if self.kind == 'wheelchair':
            chair = Solids(boxes=((pose.x, pose.y, pose.yaw, 0.5, 0.32, 0.1, 0.55),))
            return chair + _upright(pose @ SE2(-0.15, 0.0, 0.0), 0.2, 0.55, 1.3)
        if self.kind == 'lying body':
            a, b = pose @ SE2(0.0, -0.3, 0.0), pose @ SE2(0.0, 0.3, 0.0)
            return Solids(((a.x, a.y, 0.1, b.x, b.y, 0.1, 0.1),))
        places, radius, height = _UPRIGHT[self.kind]
        people = [_upright(pose @ SE2(x, y, 0.0), radius, 0.0, height) for x, y in places]
        return sum(people, Solids())

    def _legs(self, pose: SE2, time: float) -> Solids:
        """Return legs of which one rests while the other swings at twice the speed, and the body above."""
        period = 1.4 - 0.35 * min(self.speed, 1.6)
        legs = list[Cylinder]()
        for side, phase in ((_LEG_OFFSET, 0.0), (-_LEG_OFFSET, 0.5)):
            turn = (time / period + phase) % 1.0
            ahead = 0.25 - turn if turn < 0.5 else turn - 0.75
            foot = pose @ SE2(self.speed * period * ahead, side, 0.0)
            legs.append((foot.x, foot.y, 0.0, foot.x, foot.y, _LEG_HEIGHT, _LEG_RADIUS))
        return Solids(tuple(legs)) + _upright(pose, 0.18, _LEG_HEIGHT, 1.75)


def _upright(pose: SE2, radius: float, low: float, high: float) -> Solids:
    return Solids(((pose.x, pose.y, low, pose.x, pose.y, high, radius),))
