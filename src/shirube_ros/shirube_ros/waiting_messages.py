"""Messages that came while a node was at work."""

from __future__ import annotations

from rclpy.subscription import Subscription


def take_waiting(subscription: Subscription) -> None:
    """Hand all messages that wait in a subscription to its callback.

    The executor takes one message of each topic in turn. What comes many times an image, such as an imu, falls behind
    more and more while images are worked on, though the messages are there.

    Args:
        subscription: of this node; called from one of its callbacks, in the executor's thread.
    """
    while True:
        with subscription.handle:
            taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
        if taken is None:
            return
        subscription.callback(taken[0])
