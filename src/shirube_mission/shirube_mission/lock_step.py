"""Simulation in lockstep with the nodes: time advances when all nodes have processed their messages."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from time import monotonic

from rclpy.executors import Executor
from rclpy.node import Node

from motor_bridge.emulator.emulated_controller import EmulatedController
from scene_simulator.mission_sensors import MissionSensors
from shirube_bags.node_questions import NodeQuestions
from shirube_mission.mission_ears import MissionEars
from shirube_mission.mission_voice import MissionVoice
from shirube_mission.render_worker import PiecewisePath, RenderWorker
from shirube_mission.sensor_schedule import CAMERAS, STEP_MS, TILT, SensorRhythm

_LISTENER = {
    'floor': 'floor_localizer',
    'ceiling': 'vlc_beacon',
    'stereo': 'stereo_landmark',
    'depth': 'reward_planner',
}
_DRIVE_MS = 50
"""Control period of the planner [ms]."""
_ANSWER_TIMEOUT = 60.0
_MOTION_WAIT, _LOOK = 1.0, 0.02
"""Timeouts for odometry [s]. The bridge drives its serial line in a thread, so only odometry shows that it is done."""
_PATH_KNOTS = 5


class LockStep:
    """Advances the robot and the clock, step by step.

    Attributes:
        now: mission time [ms].
        late_steps: number of steps without odometry or fused pose before the timeout.
    """

    def __init__(
        self,
        node: Node,
        executor: Executor,
        controller: EmulatedController,
        lock: Lock,
        sensors: MissionSensors,
        worker: RenderWorker,
        ears: MissionEars,
        has_ended: Callable[[], bool] = lambda: False,
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
        """
        self.now = 0
        self.late_steps = 0
        self._is_heard = True
        self.voice = MissionVoice(node)
        self._executor, self._controller, self._lock = executor, controller, lock
        self._sensors, self._worker, self._ears = sensors, worker, ears
        self._questions = NodeQuestions(node, executor, has_ended)

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
                    self._order(camera, index)
            truth = self._controller.pose_at(1e-3 * self.now)
        self._sense(before)
        self.voice.tell_time(self.now)
        self.voice.tell_truth(self.now, truth)
        self._await_motion()
        if self.now // _DRIVE_MS > before // _DRIVE_MS:
            # The first response shows that the planner has received the clock, the second that its timer has run.
            for name in ('/reward_planner', '/reward_planner', '/motor_bridge'):
                self.ask(name)

    def ask(self, *names: str) -> None:
        """Wait until nodes have processed their messages.

        Raises:
            ReplayError: a node does not respond.
        """
        self._questions.ask(names, _ANSWER_TIMEOUT)

    def _order(self, camera: SensorRhythm, index: int) -> None:
        time = camera.time_ms(index)
        span = max(1, camera.exposure)
        moments = [1e-3 * (time + span * (2.0 * k / (_PATH_KNOTS - 1) - 1.0)) for k in range(_PATH_KNOTS)]
        moments = [min(moment, self._controller.time) for moment in moments]
        times = sorted(set(moments))
        poses = tuple(self._controller.pose_at(moment) for moment in times)
        if len(times) == 1:
            times, poses = [times[0] - 1e-3, times[0]], (poses[0], poses[0])
        self._worker.order(camera.name, index, 1e-3 * time, PiecewisePath(tuple(times), poses))

    def _sense(self, before: int) -> None:
        """Publish the sensor data that is due, and wait until the localizers have processed it."""
        for index in TILT.indices(before, self.now, TILT.latency):
            time = TILT.time_ms(index)
            self.voice.tell_tilt(time, self._sensors.tilt_reading(index, 1e-3 * time))
        busy = []
        for camera in CAMERAS:
            for index in camera.indices(before, self.now, camera.latency):
                pictures = self._worker.take(camera.name, index)
                self.voice.show(camera.name, camera.time_ms(index), pictures)
                busy.append(f'/{_LISTENER[camera.name]}')
        self.ask(*busy)

    def _await_motion(self) -> None:
        """Wait for the odometry and the fused pose of this step; the bridge may be reconnecting."""
        # After a step without odometry, the next wait is short.
        end = monotonic() + (_MOTION_WAIT if self._is_heard else _LOOK)
        now = 1e-3 * self.now - 1e-6
        self._is_heard = False
        while self._ears.odometry_time < now or (self._ears.fused and self._ears.fused[-1].time < now):
            if monotonic() > end:
                self.late_steps += 1
                return
            self._executor.spin_once(timeout_sec=0.01)
        self._is_heard = True
