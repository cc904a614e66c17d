"""The simulation and the nodes in lock step: time goes on when all have worked off what came before."""

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
"""The planner decides so often [ms]."""
_ANSWER_TIMEOUT = 60.0
_MOTION_WAIT, _LOOK = 1.0, 0.02
"""The bridge talks to its controller in a thread of its own, so no answer tells that it is done, only odometry [s]."""
_PATH_KNOTS = 5


class LockStep:
    """Moves the robot and time, step by step.

    Attributes:
        now: the mission's time [ms].
        late_steps: steps at whose end odometry or the fused pose had not come.
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
        """Prepare.

        Args:
            node: of the simulation.
            executor: spins it.
            controller: moves the robot; its time is the mission's.
            lock: held while the controller works.
            sensors: of the robot; the cheap ones are read here.
            worker: renders the others.
            ears: hear odometry.
            has_ended: tells whether a node has; then no answer is waited for.
        """
        self.now = 0
        self.late_steps = 0
        self._is_heard = True
        self.voice = MissionVoice(node)
        self._executor, self._controller, self._lock = executor, controller, lock
        self._sensors, self._worker, self._ears = sensors, worker, ears
        self._questions = NodeQuestions(node, executor, has_ended)

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
        self._sense(before)
        self.voice.tell_time(self.now)
        self.voice.tell_truth(self.now, truth)
        self._await_motion()
        if self.now // _DRIVE_MS > before // _DRIVE_MS:
            # The first answer tells that the planner has heard the time, the second that its timer has worked.
            for name in ('/reward_planner', '/reward_planner', '/motor_bridge'):
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

    def _sense(self, before: int) -> None:
        """Publish what the sensors have by now, and wait until the nodes have made of it what they can."""
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
        """Wait for the odometry and the fused pose of this step; the bridge may be looking for its controller."""
        # Who was silent in the last step is not waited for long again.
        end = monotonic() + (_MOTION_WAIT if self._is_heard else _LOOK)
        now = 1e-3 * self.now - 1e-6
        self._is_heard = False
        while self._ears.odometry_time < now or (self._ears.fused and self._ears.fused[-1].time < now):
            if monotonic() > end:
                self.late_steps += 1
                return
            self._executor.spin_once(timeout_sec=0.01)
        self._is_heard = True
