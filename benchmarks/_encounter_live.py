"""One encounter through the live node collision_monitor, in real time, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from time import monotonic

import numpy as np
import rclpy
from _encounter_runs import LOOK, STEP, Base, Outcome, settings_for, source_for
from _encounter_scenes import HEIGHT, RADIUS, Encounter, encounter, judge_contact
from geometry_msgs.msg import TwistStamped
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from std_msgs.msg import Header

from shirube_core.geometry import SE2

_CONTROL_STEPS = 5
_START_SECONDS = 120.0


def parameters_for(scene: Encounter) -> list[str]:
    """Return the arguments of the node for a robot and its sensor."""
    settings, sensor = settings_for(scene.deceleration), scene.sensor
    source = source_for(sensor)
    values = {
        'robot_radius': settings.robot_radius,
        'deceleration': settings.deceleration,
        'latency': settings.latency,
        'front.type': source.type,
        'front.range_max': source.range_max,
        'front.xyz': list(map(float, sensor.mount.xyz)),
        'front.rpy': list(map(float, sensor.mount.rpy)),
    }
    return ['--ros-args', *(part for name, value in values.items() for part in ('-p', f'{name}:={value}'))]


class LiveRobot:
    """Publishes commands and measurements, and drives a simulated base by what the node publishes."""

    def __init__(self, scene: Encounter, seed: int) -> None:
        self.node, self.scene = rclpy.create_node('encounter'), scene
        self.rng = np.random.default_rng((24, seed))
        self.base, self.time = Base(SE2(0.0, 0.0, 0.0), scene.deceleration), -LOOK
        self.commands = self.node.create_publisher(TwistStamped, 'cmd_vel_in', 10)
        kind, topic = (PointCloud2, 'points') if scene.sensor.rows else (LaserScan, 'scan')
        self.ranges = self.node.create_publisher(kind, topic, qos_profile_sensor_data)
        self.node.create_subscription(TwistStamped, 'cmd_vel', self._take, 10)

    def _take(self, message: TwistStamped) -> None:
        self.base.give(self.time, message.twist.linear.x, message.twist.angular.z)

    def command(self) -> None:
        """Publish the command."""
        message = TwistStamped()
        if self.time >= 0.0:
            message.twist.linear.x, message.twist.angular.z = self.scene.command
        self.commands.publish(message)

    def measure(self) -> None:
        """Publish a measurement of now."""
        sensor, solids = self.scene.sensor, self.scene.walker.solids_at(self.time)
        stamp = self.node.get_clock().now().to_msg()
        ranges = sensor.ranges(self.scene.room, solids, self.base.pose, self.rng)
        header = Header(stamp=stamp, frame_id='sensor')
        if not sensor.rows:
            step = sensor.view / (sensor.columns - 1)
            self.ranges.publish(LaserScan(header=header, angle_min=-0.5 * sensor.view, angle_increment=step,
                                          range_min=0.01, range_max=30.0, ranges=ranges.tolist()))  # fmt: skip
            return
        points = (sensor.directions * ranges[:, None]).astype('<f4')
        fields = [
            PointField(name='xyz'[k], offset=4 * k, datatype=PointField.FLOAT32, count=1) for k in range(3)
        ]
        self.ranges.publish(PointCloud2(header=header, height=1, width=len(points), fields=fields, point_step=12,
                                        row_step=12 * len(points), data=points.tobytes()))  # fmt: skip


def run_live(seed: int) -> Outcome:
    """Drive an encounter until contact or its end."""
    scene = encounter(seed)
    command = [sys.executable, '-m', 'reward_planner.commands.collision_monitor', *parameters_for(scene)]
    process = subprocess.Popen(command, env=os.environ, stderr=subprocess.DEVNULL)
    rclpy.init()
    try:
        robot = LiveRobot(scene, seed)
        end = monotonic() + _START_SECONDS
        while robot.ranges.get_subscription_count() == 0 or robot.node.count_publishers('cmd_vel') == 0:
            rclpy.spin_once(robot.node, timeout_sec=0.1)
            if monotonic() > end or process.poll() is not None:
                raise RuntimeError('the node does not start')
        return _drive(robot)
    finally:
        process.terminate()
        process.wait()
        rclpy.try_shutdown()


def _drive(robot: LiveRobot) -> Outcome:
    scene, times, poses, speeds = robot.scene, list[float](), list[SE2](), list[float]()
    begin, next_frame, late, step = monotonic() + LOOK, -LOOK, 0.0, -round(LOOK / STEP)
    while STEP * step < scene.end:
        robot.time = STEP * step
        if step % _CONTROL_STEPS == 0:
            robot.command()
        if robot.time >= next_frame:
            next_frame += 1.0 / scene.sensor.rate
            robot.measure()
        late = max(late, monotonic() - begin - robot.time - STEP)
        while (left := begin + robot.time + STEP - monotonic()) > 0.0:
            rclpy.spin_once(robot.node, timeout_sec=left)
        rclpy.spin_once(robot.node, timeout_sec=0.0)
        robot.base.step(robot.time)
        times.append(robot.time + STEP)
        poses.append(robot.base.pose)
        speeds.append(robot.base.forward)
        gap = scene.walker.solids_at(times[-1]).clearance(poses[-1].x, poses[-1].y, RADIUS, HEIGHT)
        if gap <= 0.0:
            # A machine that is late measures late, too.
            view = (
                judge_contact(scene, times, poses, speeds, 1.0 / scene.sensor.rate + late)
                if step >= 0
                else None
            )
            return Outcome(step >= 0, speeds[-1], view)
        step += 1
    return Outcome(False)
