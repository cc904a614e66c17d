"""What motor_bridge makes of faults of line and controller: `./shirube bench motor_faults [--replies 1000000]`.

Prints a table: replies and commands corrupted in memory, a disconnected terminal, the time from cmd_vel
to the wire, a bridge that is killed while it drives, and a controller that is held and let go (all on
pseudo-terminals, in real time).
"""

from __future__ import annotations

import argparse

from _motor_fuzz import fuzz
from _motor_line import disconnect_terminal, kill_bridge, suspend_controller, wire_latency


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--replies', type=int, default=1_000_000, help='that are fuzzed')
    parser.add_argument('--pulls', type=int, default=100, help='of the terminal')
    parser.add_argument('--commands', type=int, default=500, help='whose latency is measured')
    parser.add_argument('--stops', type=int, default=10, help='of the bridge, and of the controller')
    options = parser.parse_args()
    print('| what | figure |\n|---|---|')
    for rows in (
        fuzz(options.replies, 7).rows(),
        disconnect_terminal(options.disconnections),
        wire_latency(options.commands),
        kill_bridge(options.stops),
        suspend_controller(options.stops),
    ):
        for name, figure in rows:
            print(f'| {name} | {figure} |', flush=True)


if __name__ == '__main__':
    main()
