"""The light as a channel: `./shirube bench light_channel [--share 0.01] [--processes 2]`.

Lamps are simulated sample by sample: waveform, clock offset, jitter, exposure, noise, lost frames; what the camera
reads goes to the decoders. Prints tables: what the codes state and what was measured, packets right, wrong and missed
under each difficulty, how long a command takes, wrong IDs and commands in a million packets, the decoders' times.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from typing import Any

import numpy as np
from _light_errors import LINKS, ROUNDS, Errors, lamp_errors, random_command, random_id
from _light_links import Channel, Link, camera_brightness, manchester_link
from tqdm import tqdm

from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.packet.packet_reader import Packet

MILLION = 1_000_000
PARTS = ('codes', 'ids', 'distance', 'latency', 'errors', 'time')
RUN_SECONDS = 40.0
LARGE = manchester_link(8)
WEIGHTS = (0.1, 0.6, 0.3)
"""Shares of the million packets; those of UFSOOK take the most frames."""
DIFFICULTIES: dict[str, list[dict[str, Any]]] = {
    'SNR': [{'snr': snr} for snr in (3.0, 5.0, 8.0, 10.0, 15.0, 30.0)],
    'clock offset ppm': [{'clock_offset': ppm} for ppm in (-100.0, -30.0, 0.0, 30.0, 100.0)],
    'frames lost': [{'lost': share} for share in (0.0, 0.01, 0.03, 0.1)],
    'jitter s': [{'jitter': jitter} for jitter in (0.0, 50e-6, 100e-6, 200e-6)],
}
EXPOSURES = {'UFSOOK': (1e-4, 5e-4, 1e-3, 2e-3), 'rolling': (20e-6, 60e-6, 80e-6, 100e-6)}
ROW_FACTORS = (0.6, 0.8, 1.0, 1.5, 2.0)
"""Rows that the lamp covers over those that the code states; the lamp is the nearer the more."""
DISTANCES = (1.25, 1.7, 2.5, 3.2, 4.0, 5.0)
"""Of the paper's lamp from the camera [m]."""
USUAL_DISTANCE, LAMP_PIXELS = 2.5, 0.065 * 636.4
"""Where the SNR is the usual one [m], and the diameter of the paper's lamp in its camera at 1 m [px]."""


def packets_right_and_wrong(
    link: Link, channel: Channel, packet: Packet, seconds: float, rng: np.random.Generator
) -> tuple[float, int, int]:
    """Return how often a packet was played whole, and how many plays were read right and packets read wrong."""
    waveform = link.play([packet.to_bytes()], channel)
    got = link.simulate_reception(waveform, link.stamps(seconds, rng), channel, rng)
    # Slots of one play may be enough for two readings; that counts once.
    right = len({int(one.stamp / waveform.period) for one in got if one.packet == packet})
    # The last packet is known a little after its end; what the ends of a run cut off was not played whole.
    sent = max(right, int(seconds / waveform.period - 1.0))
    return sent, right, sum(one.packet != packet for one in got)


def difficulty_row(link: Link, channel: Channel, runs: int, seed: int) -> str:
    """Return IDs right, wrong and missed in percent, over several lamps."""
    sums = np.zeros(3)
    for run in range(runs):
        rng = np.random.default_rng([seed, run])
        sums += packets_right_and_wrong(link, channel, random_id(rng), RUN_SECONDS, rng)
    sent, right, wrong = sums
    return f'{100 * right / sent:.1f} / {wrong:.0f} / {100 - 100 * right / sent:.1f}'


def print_profiles(runs: int) -> None:
    """Prints what the codes state and the time of 100 bytes as measured."""
    print('### Codes\n')
    print(
        '| code | rows, at 18.9 µs a row | ID s | command s | 100 bytes s | bit/s | 100 bytes s, measured |'
    )
    print('|---|---|---|---|---|---|---|')
    for link in (*LINKS, manchester_link(2), manchester_link(4), LARGE):
        stated, right = link.profile, 0
        seconds = 8.0 * stated.seconds_per_100_bytes
        for run in range(runs):
            rng = np.random.default_rng([99, run])
            data = DataPacket(rng.bytes(100))
            right += packets_right_and_wrong(link, link.default_channel, data, seconds, rng)[1]
        measured = f'{runs * seconds / right:.2f}' if right else 'none read'
        print(
            f'| {link.name} | {stated.rows_min if link.default_channel.rows else "–"} | {stated.id_seconds:.2f} '
            f'| {stated.command_seconds:.2f} | {stated.seconds_per_100_bytes:.2f} '
            f'| {800.0 / stated.seconds_per_100_bytes:.0f} | {measured} |',
            flush=True,
        )
    print(
        '\nMeasured: total time in view over the number of decoded packets, from a cold start, SNR 15, 100 ppm.\n'
    )


def print_difficulties(runs: int) -> None:
    """Prints IDs right, wrong and missed for each code and difficulty."""
    print(
        f'### IDs with impairments\n\nRight % / wrong (number) / missed %, {runs} lamps of {RUN_SECONDS:g} s each.\n'
    )
    heads = ' | '.join(link.name for link in LINKS)
    print(f'| | {heads} |\n|---|---|---|---|')
    for name, changes in DIFFICULTIES.items():
        for change in changes:
            value = next(iter(change.values()))
            cells = [difficulty_row(link, replace(link.default_channel, **change), runs, 1) for link in LINKS]
            print(f'| {name} {value:g} | {" | ".join(cells)} |', flush=True)
    for global_one, rolling in zip(*EXPOSURES.values(), strict=True):
        exposures = (global_one, rolling, rolling)
        cells = [
            difficulty_row(link, replace(link.default_channel, exposure=exposure), runs, 2)
            for link, exposure in zip(LINKS, exposures, strict=True)
        ]
        print(
            f'| exposure µs {1e6 * global_one:g}, rolling {1e6 * rolling:g} | {" | ".join(cells)} |',
            flush=True,
        )
    for factor in ROW_FACTORS:
        cells = ['–']
        for link in LINKS[1:]:
            rows = round(factor * link.default_channel.rows)
            cells.append(
                f'{difficulty_row(link, replace(link.default_channel, rows=rows), runs, 3)} ({rows} rows)'
            )
        print(f'| rows × {factor:g} | {" | ".join(cells)} |', flush=True)
    print()


def at_distance(link: Link, distance: float) -> Channel:
    """Return the channel of the paper's lamp at a distance [m].

    A pixel in the lamp's image is as bright as before; there are fewer of them to average, in the lamp and in a row.
    """
    nearer = USUAL_DISTANCE / distance
    if link.default_channel.rows:
        return replace(
            link.default_channel,
            rows=round(LAMP_PIXELS / distance),
            snr=link.default_channel.snr * nearer**0.5,
        )
    return replace(link.default_channel, snr=link.default_channel.snr * nearer)


def print_distances(runs: int) -> None:
    """Prints IDs right, wrong and missed against distance; the lamp of the paper is too small for Manchester slots."""
    print(
        f'### IDs against distance\n\nThe lamp of 65 mm, SNR 15 at {USUAL_DISTANCE:g} m; '
        f'right % / wrong (number) / missed %, {runs} lamps of {RUN_SECONDS:g} s each.\n'
    )
    links = LINKS[:2]
    print(f'| distance m | lamp px | {" | ".join(link.name for link in links)} |\n|---|---|---|---|')
    for distance in DISTANCES:
        cells = [difficulty_row(link, at_distance(link, distance), runs, 7) for link in links]
        print(f'| {distance:g} | {LAMP_PIXELS / distance:.0f} | {" | ".join(cells)} |', flush=True)
    print()


def print_latencies(runs: int) -> None:
    """Prints how long a robot looks at a lamp until it has read the command."""
    print(
        '### Latency of a command\n\nFrom the first frame with the lamp, SNR 15, 100 ppm, 1 % of frames lost.\n'
    )
    print('| code | lamp plays | median s | 95 % s | not within 60 s |\n|---|---|---|---|---|')
    for link in (*LINKS, LARGE):
        channel = replace(link.default_channel, lost=0.01)
        for name, ids in (('command only', 0), ('ID, ID, command', 2)):
            waits = []
            for run in range(runs):
                rng = np.random.default_rng([4, run])
                beacon = random_id(rng)
                command = random_command(rng, beacon.beacon)
                waveform = link.play([*[beacon.to_bytes()] * ids, command.to_bytes()], channel)
                stamps = link.stamps(60.0, rng)
                ends = [
                    got.stamp
                    for got in link.simulate_reception(waveform, stamps, channel, rng)
                    if got.packet == command
                ]
                waits.append(min(ends, default=np.inf) - stamps[0])
            median, late = np.quantile(waits, [0.5, 0.95], method='higher')
            none = np.count_nonzero(np.isinf(waits))
            print(f'| {link.name} | {name} | {median:.1f} | {late:.1f} | {none} of {runs} |', flush=True)
    print()


def print_errors(share: float, processes: int) -> None:
    """Prints what went wrong in a million packets."""
    print('### Wrong IDs and commands\n')
    print('Lamps send their ID nine times and a command, under SNR 2–20, exposure × 0.3–1.7, rows × 0.8–1.5,')
    print('±100 ppm, jitter up to 150 µs, up to 5 % of frames lost. All 16 384 IDs are known.\n')
    print(
        '| code | played | read right | IDs: single wrong | reported wrong | commands: single wrong | signed wrong |'
    )
    print('|---|---|---|---|---|---|---|', flush=True)
    total = Errors()
    with get_context('spawn').Pool(processes) as pool:
        for index, (link, weight) in enumerate(zip(LINKS, WEIGHTS, strict=True)):
            jobs = max(1, round(MILLION * weight * share / (10 * ROUNDS)))
            results = pool.imap_unordered(partial(lamp_errors, index), range(jobs))
            errors = sum(tqdm(results, total=jobs, desc=link.name, leave=False), Errors())
            print(f'| {link.name} | {errors.cells()} |', flush=True)
            total += errors
    print(f'| all | {total.cells()} |\n', flush=True)


def print_times() -> None:
    """Prints how long decoders take for the lamps of a frame, frame by frame as a node does it."""
    print('### Time\n\nProcessing time of a frame, one core, without the first 3 s.\n')
    print('| lamps in the frame | median µs | 99 % µs | longest µs |\n|---|---|---|---|')
    for link, lamps in ((LINKS[0], 4), (LINKS[1], 4), (LINKS[2], 2), (LARGE, 1)):
        rng = np.random.default_rng(6)
        stamps = link.stamps(60.0, rng)
        seen, decoders = [], [link.decoder(link.default_channel) for _ in range(lamps)]
        for beacon in (random_id(rng) for _ in range(lamps)):
            command = random_command(rng, beacon.beacon).to_bytes()
            waveform = link.play([beacon.to_bytes(), beacon.to_bytes(), command], link.default_channel)
            seen.append(camera_brightness(waveform, stamps, link.default_channel, rng))
        times = []
        for k in range(len(stamps)):
            begin = time.process_time()
            for decode, frames in zip(decoders, seen, strict=True):
                decode(stamps[k : k + 1], frames[k : k + 1])
            times.append(1e6 * (time.process_time() - begin))
        counted = times[round(3.0 * link.frame_rate) :]
        median, late = np.quantile(counted, [0.5, 0.99])
        rows = f' of {link.default_channel.rows} rows' if link.default_channel.rows else ''
        print(f'| {lamps} {link.name}{rows} | {median:.0f} | {late:.0f} | {max(counted):.0f} |', flush=True)


def main() -> int:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else '')
    parser.add_argument('--share', type=float, default=1.0, help='of the lamps and of the million packets')
    parser.add_argument('--processes', type=int, default=1)
    parser.add_argument('--only', nargs='+', default=PARTS, choices=PARTS, help='the tables to make')
    options = parser.parse_args()
    runs = max(2, round(50 * options.share))
    parts: dict[str, Callable[[], None]] = {
        'codes': partial(print_profiles, max(1, runs // 10)),
        'ids': partial(print_difficulties, runs),
        'distance': partial(print_distances, runs),
        'latency': partial(print_latencies, 2 * runs),
        'errors': partial(print_errors, options.share, options.processes),
        'time': print_times,
    }
    for name in options.only:
        parts[name]()
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
