"""What people do to the simulated robot: cover cameras, switch lamps off, carry it, stand in its way."""

import json
import math
from collections.abc import Callable, Sequence

import numpy as np
from rclpy.node import Node
from std_msgs.msg import String

from scene_simulator.mission.pedestrians import Pedestrian
from shirube_bringup.render_worker import Picture
from shirube_core.geometry import SE2
from shirube_ros.quality_of_service import pose_profile

_WAY, _SPEED = 3.0, 0.8
"""Length of a walker's way [m] and its speed [m/s]."""


class Interventions:
    """Takes requests on ``/simulation/request`` (String, JSON) while the mission runs.

    Attributes:
        people: people whom the requests have put into the room.
    """

    def __init__(self, node: Node, carry_to: Callable[[SE2], None]) -> None:
        """Subscribe; ``carry_to`` puts the robot somewhere else in the map."""
        self.people: list[Pedestrian] = []
        self._carry_to, self._dark = carry_to, set[str]()
        node.create_subscription(String, '/simulation/request', self._take, pose_profile())

    def apply(self, sensor: str, pictures: Sequence[Picture]) -> Sequence[Picture]:
        """Return the pictures of a sensor as they are with its cover, or without the light of the lamps."""
        if sensor in self._dark:
            return [np.zeros_like(picture) for picture in pictures]
        if sensor == 'ceiling' and 'lamps' in self._dark:
            return [np.minimum(picture, np.median(picture).astype(picture.dtype)) for picture in pictures]
        return pictures

    def _take(self, message: String) -> None:
        request = json.loads(message.data)
        what = request['what']
        if what in ('cover', 'lamps'):
            change = self._dark.add if request['on'] else self._dark.discard
            change(request.get('camera', what))
        elif what == 'clear':
            self.people.clear()
        elif what == 'kidnap':
            self._carry_to(SE2(request['x'], request['y'], request['yaw']))
        else:
            x, y, yaw = request['x'], request['y'], request['yaw']
            end = x + _WAY * math.cos(yaw), y + _WAY * math.sin(yaw)
            self.people.append(Pedestrian((x, y), end, 0.0 if what == 'obstacle' else _SPEED))
