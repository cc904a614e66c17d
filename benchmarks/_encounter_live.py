"""One encounter through the live node collision_monitor, in real time, in a process of its own."""

from time import monotonic

import numpy as np
import rclpy
from _encounter_runs import LOOK, STEP, Base, Outcome, settings_for, source_for
from _encounter_scenes import HEIGHT, RADIUS, Encounter, encounter, judge_contact
from _live_node import running_node
from geometry_msgs.msg import TwistStamped
from node_testing import cloud_from_points
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan, PointCloud2
from std_msgs.msg import Header

from shirube_core.geometry import SE2

_CONTROL_STEPS = 5


def parameters_for(scene: Encounter) -> dict[str, object]:
    """Return the parameters of the node for a robot and its sensor."""
    settings, sensor = settings_for(scene.deceleration), scene.sensor
    source = source_for(sensor)
    return {
        'robot_radius': settings.robot_radius,
        'deceleration': settings.deceleration,
        'latency': settings.latency,
        'front.type': source.type,
        'front.range_max': source.range_max,
        'front.xyz': list(map(float, sensor.mount.xyz)),
        'front.rpy': list(map(float, sensor.mount.rpy)),
    }


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
        points = (sensor.directions * ranges[:, None]).astype(np.float32)
        self.ranges.publish(cloud_from_points(points, header))


def run_live(seed: int) -> Outcome:
    """Drive an encounter until contact or its end."""
    scene = encounter(seed)
    with running_node('reward_planner.commands.collision_monitor', parameters_for(scene)) as wait_until:
        robot = LiveRobot(scene, seed)
        ranges, node = robot.ranges, robot.node
        wait_until(node, lambda: ranges.get_subscription_count() > 0 and node.count_publishers('cmd_vel') > 0)
        return _drive(robot)


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
            view = judge_contact(scene, times, poses, speeds, 1.0 / scene.sensor.rate + late) if step >= 0 else None
            return Outcome(step >= 0, speeds[-1], view)
        step += 1
    return Outcome(False)
