"""What motor_bridge makes of faults of line and controller.

Replies and commands corrupted in memory; then on pseudo-terminals, in real time: a disconnected terminal, the time from
cmd_vel to the wire, a bridge that is killed while it drives, and a controller that is held and let go.
"""

from _figures import count, error, measured, rate
from _harness import Option, Run, run_benchmark
from _motor_fuzz import FuzzedDrive
from _motor_line import connecting_time, disconnect_terminal, kill_bridge, suspend_controller, wire_latency


def main(run: Run, replies: int, disconnections: int, commands: int, stops: int) -> None:
    """Corrupt, disconnect, kill and hold."""
    drive, checked = FuzzedDrive(6 + run.seed), FuzzedDrive(6 + run.seed, firmware='motor_controller')
    drive.run(replies)
    checked.run(replies)
    line, statuses = drive.line, drive.odometry.status_counts
    table = run.table('Corrupted replies and commands', 'what', 'figure')
    for name, figure in (
        ('replies of the controller', count(line.replies)),
        ('corrupted replies and commands', count(line.faults.total())),
        ('exceptions out of the conversation', count(drive.exceptions, better='lower')),
        ('commands beyond the limits', count(drive.over_limit, better='lower')),
        ('greatest commanded wheel speed, fraction of the limit', count(drive.fastest, '.3f')),
        ('well-formed wrong counts taken by odometry', rate(len(drive.wrong_mm), line.wrong_sent, 'lower')),
        ('with checksums', rate(len(checked.wrong_mm), checked.line.wrong_sent, 'lower')),
        ('by which a wheel was wrong until the next read, mm', error(drive.wrong_mm)),
        ('greatest step of odometry beyond the true one', count(1e3 * drive.jump, '.1f', ' mm', 'lower')),
        ('way of the wheels', measured(drive.path, '.0f', ' m')),
        *((f'counts {status.value}', count(number)) for status, number in statuses.items()),
    ):
        table.add(name, figure)
    table = run.table('On pseudo-terminals, in real time', 'what', 'figure')
    for rows in (
        disconnect_terminal(disconnections),
        wire_latency(commands),
        kill_bridge(stops),
        kill_bridge(stops, 'motor_controller'),
        connecting_time(stops),
        suspend_controller(stops),
    ):
        for name, figure in rows:
            table.add(name, figure)


if __name__ == '__main__':
    run_benchmark(
        main,
        replies=Option(1_000_000, 10_000, 'that are fuzzed'),
        disconnections=Option(100, 2, 'of the terminal'),
        commands=Option(500, 20, 'whose latency is measured'),
        stops=Option(10, 1, 'of the bridge, and of the controller'),
    )
