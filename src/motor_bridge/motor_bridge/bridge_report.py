"""Diagnostic status of the node."""

from motor_bridge.core.encoder_monitor import CountStatus
from motor_bridge.link.controller_session import ControllerSession
from shirube_ros.diagnostics import Level, Status


def bridge_status(session: ControllerSession, now: float, publishers: int, problem: str) -> Status:
    """Return the diagnostic status of the serial link, the wheels and the commands.

    ``now`` is 0 before simulated time starts; ``publishers`` is the number of those of commands; ``problem`` why they
    are ignored, or empty.
    """
    report = session.report
    with session.lock:
        velocity = session.drive.velocity
        is_timed_out = session.drive.is_timed_out(now)
        status_counts = dict(session.odometry.status_counts)
    level, message = Level.OK, 'driving'
    if now <= 0.0:
        level, message = Level.WARN, 'waiting for /clock; publish it, or set use_sim_time to false'
    elif not report.is_connected:
        level, message = Level.ERROR, report.state
    elif problem:
        level, message = Level.WARN, problem
    elif is_timed_out:
        message = 'stopped, cmd_vel timed out' if publishers else 'stopped, no publisher of cmd_vel'
    values = {
        'forward [m/s]': f'{velocity.forward:.3f}',
        'turn rate [rad/s]': f'{velocity.turn_rate:.3f}',
        'connections': str(report.connections),
    }
    values |= {kind: str(number) for kind, number in dict(report.faults).items()}
    values |= {f'counts {status.value}': str(status_counts.get(status, 0)) for status in CountStatus}
    return Status(level, message, values)
