"""``collision_monitor``: the node that limits velocities by fresh ranges, see docs/collision_monitor.md."""

from __future__ import annotations

import sys

from shirube_ros.start import run_main


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_main('reward_planner.collision_monitor_node')


if __name__ == '__main__':
    sys.exit(main())
