"""Starts an installed node, waits until it speaks on /diagnostics, and ends it with SIGINT."""

import signal
import subprocess
import sys
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from domain_coordinator import domain_id
from rclpy.executors import SingleThreadedExecutor

# The first start after a build compiles the node's kernels [s].
PATIENCE = 300.0


def main() -> int:
    """Returns 0 when the node answered and ended with exit code 0."""
    with domain_id() as domain:
        return check_node(sys.argv[1:], int(domain))


def check_node(command: list[str], domain: int) -> int:
    """Starts the node in a domain of its own and tells how it did."""
    said: list[str] = []
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    listener = rclpy.create_node('listener', context=context)
    listener.create_subscription(
        DiagnosticArray, '/diagnostics', lambda m: said.extend(f'{s.name}: {s.message}' for s in m.status), 10
    )
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(listener)
    node = subprocess.Popen(['env', f'ROS_DOMAIN_ID={domain}', *command], start_new_session=True)
    try:
        end = time.monotonic() + PATIENCE
        while not said and node.poll() is None and time.monotonic() < end:
            executor.spin_once(timeout_sec=0.2)
        alive = node.poll() is None
        node.send_signal(signal.SIGINT)
        code = node.wait(timeout=20)
    finally:
        node.kill()
        listener.destroy_node()
        context.shutdown()
    print(f'alive: {alive}; /diagnostics: {said[:1]}; exit code after SIGINT: {code}')
    return 0 if alive and said and code == 0 else 1


if __name__ == '__main__':
    sys.exit(main())
