"""Diagnostic status of the node."""

from __future__ import annotations

from collections.abc import Sequence

from motor_bridge.conversation import Conversation
from motor_bridge.core.count_watch import CountVerdict
from shirube_ros.diagnostics import Level, Status


def bridge_status(talk: Conversation, now: float, wanted: str, offered: Sequence[str]) -> Status:
    """Return the diagnostic status of the serial link, the wheels and cmd_vel.

    Args:
        session: session with the controller.
        now: current time [s], 0 before simulated time starts.
        expected_type: message type of the node's cmd_vel subscription.
        published_types: message type of each publisher of cmd_vel.
    """
    report = talk.report
    with talk.lock:
        velocity = talk.drive.velocity
        is_stopped, is_silent = talk.drive.is_stopped, talk.drive.is_silent(now)
        verdicts = dict(talk.odometry.verdicts)
    level, message = Level.OK, 'driving'
    if now <= 0.0:
        level, message = Level.WARN, 'waiting for /clock; publish it, or set use_sim_time to false'
    elif not report.is_connected:
        level, message = Level.ERROR, report.state
    elif is_stopped:
        level, message = Level.WARN, 'stopped by estop'
    elif len(offered) > 1:
        level, message = Level.WARN, f'{len(offered)} nodes publish cmd_vel, all are ignored; keep one'
    elif offered and offered[0] != wanted:
        level = Level.WARN
        message = f'cmd_vel is published as {offered[0]}, not as {wanted}; change stamped'
    elif is_silent:
        message = 'stopped, cmd_vel timed out' if offered else 'stopped, no publisher of cmd_vel'
    values = {
        'forward [m/s]': f'{velocity.forward:.3f}',
        'turn rate [rad/s]': f'{velocity.turn_rate:.3f}',
        'connections': str(report.connections),
    }
    values |= {kind: str(number) for kind, number in dict(report.faults).items()}
    values |= {f'counts {verdict.value}': str(verdicts.get(verdict, 0)) for verdict in CountVerdict}
    return Status(level, message, values)
