"""``save_map``: asks a running node to write its map, for where there is no ``ros2 service call``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import rclpy
from std_srvs.srv import Trigger

_WAIT = 5.0  # for the node, and for its answer [s]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when nobody answers or the map was not saved."""
    parser = argparse.ArgumentParser(
        prog='save_map',
        description='Ask a running reward_planner to write its map where its parameter save_file says.',
    )
    parser.add_argument('--node', default='/reward_planner', help='its name (default: %(default)s)')
    given = rclpy.utilities.remove_ros_args(sys.argv if arguments is None else ['save_map', *arguments])
    options = parser.parse_args(given[1:])
    answer = call(f'{options.node}/save_map')
    if answer is None:
        print(f'save_map: {options.node} does not answer; start it first', file=sys.stderr)
        return 1
    print(answer.message if answer.success else f'save_map: {answer.message}',
          file=sys.stdout if answer.success else sys.stderr)  # fmt: skip
    return 0 if answer.success else 1


def call(service: str) -> Trigger.Response | None:
    """Return the answer of a service, None where there is none in time."""
    rclpy.init()
    try:
        node = rclpy.create_node('save_map')
        client = node.create_client(Trigger, service)
        if not client.wait_for_service(_WAIT):
            return None
        future = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(node, future, timeout_sec=_WAIT)
        answer: Trigger.Response | None = future.result()
        return answer
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    sys.exit(main())
