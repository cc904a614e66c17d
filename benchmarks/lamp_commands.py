"""Figure 4: commands that reach a moving robot at the paper's scale, by light code and speed, and what limits them.

A rule must be read between the lamp's appearance, 2 m ahead, and the lamp: in the worst case a packet has just begun,
and all that the lamp sends follows. This gives the speed at which every drive obeys; faster ones obey by chance.
"""

import math

import numpy as np
from _figures import count, error, measured, rate
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _lamp_commands import CHANNELS, A, B, drive, programs
from _lamp_films import BEACONS, KEY, Channel

from vlc_beacon.core.packet.command_packet import Operation
from vlc_beacon.core.transmitter.message_encoder import EncoderContext, encode_messages

AHEAD = 2.0  # of the robot lamps come into view [m]
SHARES = (0.85, 1.7)  # speeds of the drives over the limit


def limits(channel: Channel) -> tuple[float, float, float]:
    """Return the durations of a command and of all that A sends [s], and the speed at which all is read in time."""
    packets = encode_messages(programs(1.0)[A], EncoderContext(A, KEY, 1))
    command, period = channel.encode(packets[1:2]).period, channel.encode(packets).period
    return command, period, AHEAD / (command + period)


def main(run: Run, drives: int, codes: int) -> None:
    """Drive the paper's run with each code, below and above the speed that it allows."""
    use_one_core()
    heads = 'command s', 'all of A s', 'limit m/s', 'driven at m/s', 'obeyed A', 'obeyed B'
    table = run.table(
        'Figure 4', 'code', *heads, 'turned from A cm: median / 95 % / max', 'pose cm: median / 95 % / max'
    )
    for channel in CHANNELS[:codes]:
        command, period, limit = limits(channel)
        for speed in (round(share * limit, 2) for share in SHARES):
            seconds, obeyed, places, errors = 6.0 + 5.5 / speed, {A: 0, B: 0}, [], []
            for seed in progress(range(drives), channel.name):
                said = list[tuple[int, Operation]]()
                for instant in drive(channel, speed, seconds, seed):
                    errors.append(instant.error)
                    said += instant.commands
                    if (A, Operation.TURN) in instant.commands:
                        x, y, _ = BEACONS[A - 1].xyz
                        places.append(math.hypot(instant.pose.x - x, instant.pose.y - y))
                for lamp in (A, B):
                    obeyed[lamp] += len({each for each in said if each[0] == lamp}) == 2
            table.add(
                *(channel.name, measured(command, '.2f'), measured(period, '.2f'), measured(limit, '.2f')),
                *(count(speed, '.2f'), rate(obeyed[A], drives), rate(obeyed[B], drives)),
                *(error(np.array(places), '.0f', 100.0), error(np.array(errors), '.2f', 100.0)),
            )


if __name__ == '__main__':
    run_benchmark(main, drives=Option(2, 1, 'of each speed'), codes=Option(3, 1, 'of the light codes'))
