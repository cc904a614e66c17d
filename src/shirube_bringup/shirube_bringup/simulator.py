"""Simulation in lockstep with the nodes: time advances when all nodes have processed their messages."""

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from threading import Lock
from time import monotonic
from typing import Any

import numpy as np
from rclpy.executors import Executor
from rclpy.node import Node
from std_msgs.msg import String

from motor_bridge.emulator.emulated_controller import EmulatedController
from scene_simulator.mission.pedestrians import Pedestrian
from scene_simulator.mission.sensors import MissionSensors
from shirube_bags.lockstep import NodeBarrier
from shirube_bringup.render_worker import Picture, PiecewisePath, RenderWorker
from shirube_bringup.topics import MissionPublishers, MissionSubscribers
from shirube_core.geometry import SE2
from shirube_ros.quality_of_service import pose_profile

KIDNAPPING = SE2(0.3, 0.2, 0.5 * math.pi)
"""Where the robot is put, seen from where it stands: within the free space around a goal."""

RECOVERED_WITHIN, RECOVERY_TIME = 0.02, 20.0
"""Error of the fused pose below which the robot has recovered [m], and the timeout [s]."""


class CarriedController(EmulatedController):
    """An emulated robot that can be carried away; arguments as for `EmulatedController`."""

    def __init__(self, *arguments: Any, **more: Any) -> None:
        """Start as it would without being carried."""
        super().__init__(*arguments, **more)
        self._carried = [(-math.inf, SE2(0.0, 0.0, 0.0))]

    @property
    def T_world_base(self) -> SE2:  # noqa: N802 the field's name for it
        """True pose now."""
        return self.pose_at(self.time)

    def pose_at(self, time: float) -> SE2:
        """Return ``T_world_base`` at a time [s], before or after it was carried."""
        displacement = next(each for since, each in reversed(self._carried) if time >= since)
        return displacement @ super().pose_at(time)

    def carry_to(self, T_world_base: SE2) -> None:
        """Put the robot somewhere else; its wheels do not turn."""
        self._carried.append((self.time, T_world_base @ super().pose_at(self.time).inverse()))


_WAY, _SPEED = 3.0, 0.8  # length of a walker's way [m] and its speed [m/s]


class Interventions:
    """Takes requests on ``/simulation/request`` (String, JSON); ``people`` are those that were put into the room."""

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


STEP_MS = 20  # time step of the simulation [ms]
SUBSCRIBERS = {
    'floor': ('/floor_localizer',),
    'ceiling': ('/vlc_beacon',),
    'stereo': ('/stereo_landmark',),
    'depth': ('/reward_planner', '/collision_monitor'),
}
"""Full names of the nodes that take the images of each sensor."""

_CONTROLLERS = ('/reward_planner', '/reward_planner', '/collision_monitor', '/motor_bridge')
_CONTROL_PERIOD_MS = 50  # control period of the planner [ms]
_RESPONSE_TIMEOUT = 60.0
_MOTION_TIMEOUT, _SHORT_TIMEOUT = 1.0, 0.02
"""Timeouts for odometry [s]. The bridge drives its serial line in a thread, so only odometry shows that it is done."""

_PATH_KNOTS = 5


@dataclass(frozen=True)
class SensorSchedule:
    """Schedule of a sensor with a fixed rate.

    Attributes:
        name: name of the sensor.
        period: time between two measurements [ms].
        first: time of the first measurement [ms].
        exposure: time from the stamp of a measurement to the end of its exposure [ms].
        latency: time from the stamp of a measurement to its publication [ms].
    """

    name: str
    period: int
    first: int
    exposure: int
    latency: int

    def indices(self, before: int, until: int, delay: int) -> Iterator[int]:
        """Yield the indices of the measurements whose time plus delay is in (before, until] [ms]."""
        index = max(0, (before - delay - self.first) // self.period + 1)
        while self.first + index * self.period + delay <= until:
            yield index
            index += 1

    def time_ms(self, index: int) -> int:
        """Return the time of a measurement [ms]."""
        return self.first + index * self.period


FLOOR = SensorSchedule('floor', 100, 100, 1, 60)
CEILING = SensorSchedule('ceiling', 80, 120, 8, 60)
STEREO = SensorSchedule('stereo', 1000, 500, 0, 200)
DEPTH = SensorSchedule('depth', 200, 160, 0, 80)
CAMERAS = (FLOOR, CEILING, STEREO, DEPTH)
TILT = SensorSchedule('tilt', 40, 20, 0, 0)


class Simulator:
    """Advances the robot and the clock, step by step.

    Attributes:
        now: mission time [ms].
        late_steps: number of steps without odometry or fused pose before the timeout.
        interventions: what people do to the robot from outside.
    """

    def __init__(
        self,
        node: Node,
        executor: Executor,
        controller: CarriedController,
        lock: Lock,
        sensors: MissionSensors,
        worker: RenderWorker,
        subscribers: MissionSubscribers,
        has_ended: Callable[[], bool] = lambda: False,
        people: Sequence[Pedestrian] = (),
    ) -> None:
        """Create the publishers.

        Args:
            node: node of the simulation.
            executor: executor of the node.
            controller: emulated controller that moves the robot; its time is the mission time.
            lock: lock of the controller.
            sensors: sensors of the robot; only the tilt is read here.
            worker: renders the images.
            subscribers: receive odometry and the fused pose.
            has_ended: returns whether a node has ended; then responses are not waited for.
            people: people who walk in the room.
        """
        self.now = 0
        self.late_steps = 0
        self._has_motion = True
        self.publishers = MissionPublishers(node)
        self._executor, self._controller, self._lock = executor, controller, lock
        self._sensors, self._worker, self._subscribers = sensors, worker, subscribers
        self._barrier = NodeBarrier(node, executor, has_ended)
        self._people = people
        self.interventions = Interventions(node, self._carry_to)

    @property
    def people(self) -> list[Pedestrian]:
        """People who walk in the room, or were put there."""
        return [*self._people, *self.interventions.people]

    def step(self) -> None:
        """Advance by one time step.

        Raises:
            ReplayError: a node does not respond.
            MotorBridgeError: the controller's time was advanced elsewhere.
        """
        before, self.now = self.now, self.now + STEP_MS
        with self._lock:
            self._controller.advance(1e-3 * self.now)
            for camera in CAMERAS:
                for index in camera.indices(before, self.now, camera.exposure):
                    self._request_render(camera, index)
            truth = self._controller.pose_at(1e-3 * self.now)
        for person in self.people:
            person.advance(1e-3 * STEP_MS, truth)
        self._publish_sensors(before)
        self.publishers.publish_clock(self.now)
        self.publishers.publish_ground_truth(self.now, truth)
        self._wait_for_motion()
        if self.now // _CONTROL_PERIOD_MS > before // _CONTROL_PERIOD_MS:
            # The first response shows that the planner has received the clock, the second that its timer has run.
            for name in _CONTROLLERS:
                self.wait_for_nodes(name)

    def wait_for_nodes(self, *names: str) -> None:
        """Wait until nodes have processed their messages, or raise a ReplayError."""
        self._barrier.wait_for_nodes(names, _RESPONSE_TIMEOUT)

    def _request_render(self, camera: SensorSchedule, index: int) -> None:
        time = camera.time_ms(index)
        span = max(1, camera.exposure)
        moments = [1e-3 * (time + span * (2.0 * k / (_PATH_KNOTS - 1) - 1.0)) for k in range(_PATH_KNOTS)]
        moments = [min(moment, self._controller.time) for moment in moments]
        times = sorted(set(moments))
        poses = tuple(self._controller.pose_at(moment) for moment in times)
        if len(times) == 1:
            times, poses = [times[0] - 1e-3, times[0]], (poses[0], poses[0])
        places = [person.place for person in self.people]
        self._worker.request(camera.name, index, 1e-3 * time, PiecewisePath(tuple(times), poses), places)

    def _publish_sensors(self, before: int) -> None:
        """Publish the sensor data that is due, and wait until the localizers have processed it."""
        for index in TILT.indices(before, self.now, TILT.latency):
            time = TILT.time_ms(index)
            self.publishers.publish_imu(time, self._sensors.tilt_reading(index, 1e-3 * time))
        busy = list[str]()
        for camera in CAMERAS:
            for index in camera.indices(before, self.now, camera.latency):
                pictures = self.interventions.apply(camera.name, self._worker.collect(camera.name, index))
                self.publishers.publish_images(camera.name, camera.time_ms(index), pictures)
                busy += SUBSCRIBERS[camera.name]
        self.wait_for_nodes(*busy)

    def _carry_to(self, T_map_base: SE2) -> None:
        with self._lock:
            self._controller.carry_to(T_map_base)

    def _wait_for_motion(self) -> None:
        """Wait for the odometry and the fused pose of this step; the bridge may be reconnecting."""
        # After a step without odometry, the next wait is short.
        end = monotonic() + (_MOTION_TIMEOUT if self._has_motion else _SHORT_TIMEOUT)
        now = 1e-3 * self.now - 1e-6
        self._has_motion = False
        while self._subscribers.odometry_time < now or (
            self._subscribers.fused and self._subscribers.fused[-1].time < now
        ):
            if monotonic() > end:
                self.late_steps += 1
                return
            self._executor.spin_once(timeout_sec=0.01)
        self._has_motion = True
