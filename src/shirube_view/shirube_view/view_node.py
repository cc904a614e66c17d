"""The node of the view: subscribes while a page is open, publishes what pages command."""

from collections.abc import Callable, Collection
from functools import partial
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist, TwistStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from std_msgs.msg import Bool, Header, String
from std_srvs.srv import Trigger

from shirube_bags.ros_session import load_message_class
from shirube_core.geometry import SE2
from shirube_ros.message_conversion import pose_stamped, pose_with_covariance_stamped
from shirube_ros.parameters import declare_parameters, reject_misspelled_parameters
from shirube_ros.quality_of_service import map_profile, pose_profile
from shirube_view.board import Board
from shirube_view.channels import CHANNELS, Channel, Kind
from shirube_view.driver import Driver
from shirube_view.settings import ViewSettings

_TICK = 0.05  # period of commands and of opening and closing subscriptions [s]
SERVICES = {
    'cancel': ('reward_planner/cancel',),
    'clear_map': ('reward_planner/clear_map',),
    'save_map': ('reward_planner/save_map',),
    'relocalize': ('pose_arbiter/reset', 'floor_localizer/relocalize', 'stereo_landmark/relocalize'),
}
_INITIAL_COVARIANCE = ((0.09, 0.0, 0.0), (0.0, 0.09, 0.0), (0.0, 0.0, 0.07))
"""Of an initial pose set by hand: 0.3 m and 15 degrees [m^2, rad^2]."""

Answer = Callable[[str, bool], None]  # takes the result of a service in words, and whether it succeeded


class ViewNode(Node):
    """Node of the view; all but `run_soon` is called in the thread of its executor.

    Attributes:
        settings: its parameters.
        board: newest messages.
        driver: dead man's switch of driving by hand.
        watched: channels that open pages show; the node subscribes to them only.
        is_simulated: whether the simulator of the demo takes requests.
    """

    def __init__(self, **options: Any) -> None:
        """Create publishers and clients; raise a SettingsError for an invalid parameter."""
        super().__init__('shirube_view', **options)
        self.settings = declare_parameters(self, ViewSettings)
        reject_misspelled_parameters(self)
        self.board, self.driver = Board(), Driver(self.settings.heartbeat_timeout)
        self.watched: Collection[str] = ()
        self.is_simulated = False
        self._tasks: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._subscriptions_by_name: dict[str, Subscription] = {}
        kind = TwistStamped if self.settings.stamped else Twist
        self._velocity = self.create_publisher(kind, 'cmd_vel_in', pose_profile())
        self._goal = self.create_publisher(PoseStamped, 'goal_pose', pose_profile())
        self._initial = self.create_publisher(PoseWithCovarianceStamped, 'initialpose', pose_profile())
        self._stop = self.create_publisher(Bool, 'estop', pose_profile())
        self._simulation = self.create_publisher(String, 'simulation/request', pose_profile())
        self._callers = {name: self.create_client(Trigger, name) for names in SERVICES.values() for name in names}
        self.create_timer(_TICK, self._tick, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def run_soon(self, task: Callable[[], None]) -> None:
        """Run a task in the thread of the executor, from any thread."""
        self._tasks.put(task)

    def send_goal(self, pose: SE2) -> None:
        """Publish a goal."""
        self._goal.publish(pose_stamped(pose, self._header()))

    def send_initial_pose(self, pose: SE2) -> None:
        """Publish an initial pose with the uncertainty of one set by hand."""
        header = self._header()
        self._initial.publish(pose_with_covariance_stamped(pose, _INITIAL_COVARIANCE, header))

    def send_stop(self, is_stop: bool) -> None:
        """Publish an emergency stop, or its release."""
        self._stop.publish(Bool(data=is_stop))

    def send_simulation(self, text: str) -> None:
        """Publish a request to the simulator, as JSON."""
        self._simulation.publish(String(data=text))

    def call(self, name: str, answer: Answer) -> None:
        """Call the services of a button; answer once for each, at once for those that nobody offers."""
        for service in SERVICES[name]:
            client = self._callers[service]
            if not client.service_is_ready():
                answer(f'nobody offers {service}; is its node running?', False)
                continue

            def done(future: Any, service: str = service) -> None:
                result = future.result()
                answer(f'{service}: {result.message}', bool(result.success))

            client.call_async(Trigger.Request()).add_done_callback(done)

    def stop(self) -> None:
        """Publish a last velocity of zero if a page drives."""
        if self.driver.velocity(monotonic()) is not None:
            self._send_velocity(0.0, 0.0)

    def _tick(self) -> None:
        while True:
            try:
                self._tasks.get_nowait()()
            except Empty:
                break
        velocity = self.driver.velocity(monotonic())
        if velocity is not None:
            self._send_velocity(velocity[0] * self.settings.forward_speed, velocity[1] * self.settings.turn_rate)
        self.is_simulated = self._simulation.get_subscription_count() > 0
        watched = set(self.watched)
        for name in self._subscriptions_by_name.keys() - watched:
            self.destroy_subscription(self._subscriptions_by_name.pop(name))
        for channel in CHANNELS:
            if channel.name in watched and channel.name not in self._subscriptions_by_name:
                self._subscriptions_by_name[channel.name] = self._subscribe(channel)

    def _subscribe(self, channel: Channel) -> Subscription:
        # Best effort: a page that is slow never holds up the robot's nodes.
        depth = 50 if channel.kind is Kind.EVERY else 1
        loose = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)
        profile = map_profile() if channel.is_latched else loose
        put = partial(self.board.put, channel)
        return self.create_subscription(load_message_class(channel.type), channel.topic, put, profile, raw=True)

    def _send_velocity(self, forward: float, turn_rate: float) -> None:
        # Without a stamp it holds whether time is simulated or not.
        message = TwistStamped(header=Header(frame_id=self.settings.base_frame))
        message.twist.linear.x, message.twist.angular.z = forward, turn_rate
        self._velocity.publish(message if self.settings.stamped else message.twist)

    def _header(self) -> Header:
        return Header(stamp=self.get_clock().now().to_msg(), frame_id=self.settings.map_frame)
