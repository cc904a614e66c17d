"""``collision_monitor``: the node that limits velocities by fresh ranges, see docs/collision_monitor.md."""

from functools import partial

from shirube_ros.start import run_main

main = partial(run_main, 'reward_planner.collision_monitor_node')

if __name__ == '__main__':
    main()
