"""The simulation and the nodes in lock step: time goes on when all have worked off what came before."""

from __future__ import annotations

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
_DRIVERS = ('/pose_arbiter', '/reward_planner', '/motor_bridge')
_ANSWER_TIMEOUT = 60.0
_ODOMETRY_WAIT = 0.1
"""The bridge talks to its controller in a thread of its own, so its answer alone does not tell that it is done [s]."""
_PATH_KNOTS = 5


class LockStep:
    """Moves the robot and time, step by step.

    Attributes:
        now: the mission's time [ms].
        odometry_waits: steps at whose end odometry had not come.
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
    ) -> None:
        """Prepare.

        Args:
            node: of the simulation.
            executor: spins it.
            controller: moves the robot; its time is the mission's.
            lock: held while the controller works.
            sensors: of the robot; the cheap ones are read here.
            worker: renders the others.
            ears: hear odometry.
        """
        self.now = 0
        self.odometry_waits = 0
        self.voice = MissionVoice(node)
        self._executor, self._controller, self._lock = executor, controller, lock
        self._sensors, self._worker, self._ears = sensors, worker, ears
        self._questions = NodeQuestions(node, executor, lambda: False)

    def step(self) -> None:
        """Let one step of time pass.

        Raises:
            ReplayError: a node does not answer.
            MotorBridgeError: the controller's time was moved by somebody else.
        """
        before, self.now = self.now, self.now + STEP_MS
        with self._lock:
            self._controller.advance(1e-3 * self.now)
            for camera in CAMERAS:
                for index in camera.indices(before, self.now, camera.exposure):
                    self._order(camera, index)
            truth = self._controller.pose_at(1e-3 * self.now)
        self.voice.tell_time(self.now)
        self.voice.tell_truth(self.now, truth)
        for index in TILT.indices(before, self.now, TILT.latency):
            time = TILT.time_ms(index)
            self.voice.tell_tilt(time, self._sensors.tilt_reading(index, 1e-3 * time))
        busy = [f'/{_LISTENER[camera.name]}' for camera in CAMERAS if self._show(camera, before)]
        self.ask(*{*busy, *_DRIVERS})
        self._await_odometry()
        for name in _DRIVERS:
            self.ask(name)

    def ask(self, *names: str) -> None:
        """Wait until nodes have worked off what they have got.

        Raises:
            ReplayError: one does not answer.
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

    def _show(self, camera: SensorRhythm, before: int) -> bool:
        """Publish the pictures that are there now; return whether there were any."""
        indices = list(camera.indices(before, self.now, camera.latency))
        for index in indices:
            self.voice.show(camera.name, camera.time_ms(index), self._worker.take(camera.name, index))
        return bool(indices)

    def _await_odometry(self) -> None:
        """Wait for the odometry of this step; the bridge may be about to find its controller."""
        end = monotonic() + _ODOMETRY_WAIT
        while self._ears.odometry_time < 1e-3 * self.now - 1e-6:
            if monotonic() > end:
                self.odometry_waits += 1
                return
            self._executor.spin_once(timeout_sec=0.01)
