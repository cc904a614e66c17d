"""``save_map``: calls the service ``~/save_map`` of a running node, without the ros2 command line."""

import argparse
import sys
from collections.abc import Sequence

import rclpy
from std_srvs.srv import Trigger

_TIMEOUT = 5.0  # timeout of the service and of its response [s]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 if the node does not respond or the map was not saved."""
    parser = argparse.ArgumentParser(
        prog='save_map', description='Save the map of a running reward_planner to the file of its parameter save_file.'
    )
    parser.add_argument('--node', default='/reward_planner', help='name of the node (default: %(default)s)')
    given = rclpy.utilities.remove_ros_args(sys.argv if arguments is None else ['save_map', *arguments])
    options = parser.parse_args(given[1:])
    answer = call(f'{options.node}/save_map')
    if answer is None:
        print(f'save_map: {options.node} does not respond; start it first', file=sys.stderr)
        return 1
    print(answer.message if answer.success else f'save_map: {answer.message}',
          file=sys.stdout if answer.success else sys.stderr)  # fmt: skip
    return 0 if answer.success else 1


def call(service: str) -> Trigger.Response | None:
    """Call a service; return its response, None after a timeout."""
    rclpy.init()
    try:
        node = rclpy.create_node('save_map')
        client = node.create_client(Trigger, service)
        if not client.wait_for_service(_TIMEOUT):
            return None
        future = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(node, future, timeout_sec=_TIMEOUT)
        answer: Trigger.Response | None = future.result()
        return answer
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    sys.exit(main())
