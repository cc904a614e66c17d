"""A zero velocity is published at shutdown, and while simulated time is paused."""

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped
from node_testing import IsolatedGraph
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from shirube_ros.velocity_publisher import VelocityPublisher


class Driven:
    """A node that publishes velocities, and a subscriber."""

    def __init__(self, graph: IsolatedGraph, **parameters: object) -> None:
        self.graph = graph
        self.node = graph.add(lambda **options: Node('driver', **options), **parameters)
        self.output = VelocityPublisher(self.node, 'cmd_vel', 'body')
        robot = graph.node('robot')
        self.received: list[TwistStamped] = []
        robot.create_subscription(TwistStamped, 'cmd_vel', self.received.append, 10)
        self._clock = robot.create_publisher(Clock, '/clock', 10)
        assert graph.spin_until(lambda: self.node.count_subscribers('cmd_vel') == 1)

    def pass_time(self, seconds: float) -> None:
        """Let simulated time run for some seconds of real time."""
        for k in range(round(20 * seconds)):
            self._clock.publish(Clock(clock=Time(sec=5, nanosec=50_000_000 * k)))
            self.graph.spin_until(lambda: False, timeout=0.05)

    @property
    def velocities(self) -> list[tuple[float, float]]:
        return [(message.twist.linear.x, message.twist.angular.z) for message in self.received]


def test_velocities_are_sent_in_the_base_frame_and_the_last_one_is_zero(graph: IsolatedGraph) -> None:
    driven = Driven(graph)
    driven.output.send(0.25, -0.5)
    driven.output.stop()
    assert graph.spin_until(lambda: driven.velocities == [(0.25, -0.5), (0.0, 0.0)])
    assert driven.received[0].header.frame_id == 'body'
    assert driven.received[0].header.stamp.sec > 0


def test_the_robot_stops_while_simulated_time_is_paused(graph: IsolatedGraph) -> None:
    driven = Driven(graph, use_sim_time=True)
    driven.pass_time(0.2)
    driven.output.send(0.25, 0.0)
    driven.pass_time(0.9)
    assert driven.velocities == [(0.25, 0.0)]
    assert graph.spin_until(lambda: driven.velocities == [(0.25, 0.0), (0.0, 0.0)], timeout=3.0)


def test_in_real_time_a_velocity_is_not_stopped(graph: IsolatedGraph) -> None:
    driven = Driven(graph)
    driven.output.send(0.0, 0.5)
    assert not graph.spin_until(lambda: len(driven.received) > 1, timeout=0.9)
