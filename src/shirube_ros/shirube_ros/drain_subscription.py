"""Drains the queue of a subscription."""

from __future__ import annotations

from rclpy.subscription import Subscription


def drain_subscription(subscription: Subscription) -> None:
    """Pass all queued messages of a subscription to its callback.

    The executor takes one message of each topic in turn. A topic with a higher rate than the images, such as an IMU,
    falls behind while images are processed, although its messages have arrived.

    Args:
        subscription: subscription of this node; call it from one of the node's callbacks, in the executor's thread.
    """
    while True:
        with subscription.handle:
            taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
        if taken is None:
            return
        subscription.callback(taken[0])
