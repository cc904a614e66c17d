"""``collision_monitor``: the node that limits velocities by fresh ranges, see docs/collision_monitor.md."""

from __future__ import annotations

import sys

from reward_planner.collision_monitor_node import main

__all__ = ['main']

if __name__ == '__main__':
    sys.exit(main())
