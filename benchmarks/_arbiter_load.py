"""CPU load of the arbiter: odometry at 500 Hz and four sources at 30 Hz."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import numpy as np
from _arbiter_bags import PoseSample
from _arbiter_fusion import add_message, messages_of, new_arbiter
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Header

from pose_arbiter.core.covariance import diagonal
from shirube_core.geometry import SE2
from shirube_ros.isolated_graph import isolated_graph
from shirube_ros.pose_conversion import odometry_message, pose_with_covariance_stamped

SECONDS, ODOMETRY_RATE, SOURCES, SOURCE_RATE = 20.0, 500, 4, 30
DELAY = 80_000_000
"""From an image to its pose, differing by a tenth from source to source [ns]."""
_NOISE = np.diag([1e-4, 1e-4, 1e-4])


def filter_cpu_fraction() -> float:
    """Return the processor time of the filter by the time of the drive: late poses, and 50 questions a second."""
    begin = 1_000_000_000_000
    odometry = [
        (begin + k * 1_000_000_000 // ODOMETRY_RATE, SE2(0.5 * k / ODOMETRY_RATE, 0.0, 0.0))
        for k in range(round(SECONDS * ODOMETRY_RATE))
    ]
    samples = [
        [
            PoseSample(begin + at, SE2(0.5e-9 * at, 0.0, 0.0), diagonal(1e-4, 1e-4))
            for at in (
                round((k + 0.2 * number) * 1e9 / SOURCE_RATE) for k in range(round(SECONDS * SOURCE_RATE))
            )
        ]
        for number in range(SOURCES)
    ]
    arrivals = sorted(
        ((m[0] + _delay(m[1]), m) for m in messages_of(samples, odometry)), key=lambda pair: pair[0]
    )
    arbiter, due, before = new_arbiter(SOURCES), begin, time.process_time()
    for now, message in arrivals:
        add_message(arbiter, message, now)
        if now >= due:
            arbiter.estimate_at(now)
            due += 20_000_000
    return (time.process_time() - before) / SECONDS


def _delay(source: int) -> int:
    return 0 if source >= SOURCES else round(DELAY * (1.0 + 0.1 * source))


def node_cpu_fraction(seconds: float) -> tuple[float, float]:
    """Return the processor time of the node by the time it ran, and its poses a second, at full rate over DDS."""
    names = [f'source{k}' for k in range(SOURCES)]
    arguments = ['--ros-args', '-p', f'sources:=[{", ".join(names)}]']
    with isolated_graph() as graph:
        environment = os.environ | {'ROS_DOMAIN_ID': str(graph.context.get_domain_id())}
        program = subprocess.Popen(
            [sys.executable, '-m', 'pose_arbiter.node', *arguments], env=environment, start_new_session=True
        )
        try:
            return _drive(
                graph.add(lambda **options: Node('robot', **options)), graph, names, program.pid, seconds
            )
        finally:
            program.send_signal(signal.SIGINT)
            program.wait(timeout=30.0)


def _drive(robot: Node, graph: object, names: list[str], pid: int, seconds: float) -> tuple[float, float]:
    spin_until = graph.spin_until  # type: ignore[attr-defined]
    odometry = robot.create_publisher(Odometry, 'odom', 100)
    sources = [
        robot.create_publisher(PoseWithCovarianceStamped, f'/{n}/pose_with_covariance', 10) for n in names
    ]
    received: list[float] = []
    robot.create_subscription(
        PoseStamped,
        '/pose_arbiter/pose',
        lambda _: received.append(time.monotonic()),
        QoSProfile(depth=5000),
    )
    assert spin_until(lambda: all(p.get_subscription_count() for p in (odometry, *sources)), timeout=60.0)  # noqa: S101
    begin, sent = time.monotonic(), [0] * (SOURCES + 1)
    used = _processor_seconds(pid)
    while (elapsed := time.monotonic() - begin) < seconds:
        is_idle = sent[SOURCES] >= elapsed * ODOMETRY_RATE
        while sent[SOURCES] < elapsed * ODOMETRY_RATE:
            header = Header(stamp=robot.get_clock().now().to_msg(), frame_id='odom')
            pose = SE2(0.5 * (time.monotonic() - begin), 0.0, 0.0)
            odometry.publish(odometry_message(pose, _NOISE, header, 'base_link'))
            sent[SOURCES] += 1
        for number, publisher in enumerate(sources):
            if sent[number] < elapsed * SOURCE_RATE:
                stamp = robot.get_clock().now().to_msg()
                pose = SE2(0.5 * (time.monotonic() - begin), 0.0, 0.0)
                publisher.publish(
                    pose_with_covariance_stamped(pose, _NOISE, Header(stamp=stamp, frame_id='map'))
                )
                sent[number] += 1
        if is_idle:
            robot.executor.spin_once(timeout_sec=2e-4)
    cpu_fraction = (_processor_seconds(pid) - used) / elapsed
    return cpu_fraction, (len(received) - 1) / (received[-1] - received[0])  # from the first pose on


def _processor_seconds(pid: int) -> float:
    with open(f'/proc/{pid}/stat') as file:  # noqa: PTH123
        fields = file.read().rsplit(') ', 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
