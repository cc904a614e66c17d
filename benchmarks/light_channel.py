"""The light as a channel: packets right, wrong and missed under impairments, latency, a million packets, time.

Lamps are simulated sample by sample: waveform, clock offset, jitter, exposure, noise, lost frames; what the camera
reads goes to the decoders. SNR is the brightness over the noise of a half of the panel, or of the mean of a row.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
from _figures import error, outcomes, rate, time
from _harness import Option, Run, cpu_time, in_processes, progress, run_benchmark
from _light_links import Channel, Link, camera_brightness, manchester_link, rs_fsk_link, ufsook_link

from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.id_confirmation import IdConfirmation
from vlc_beacon.core.packet.id_packet import BEACON_ID_MAX, IdPacket
from vlc_beacon.core.packet.operation import Operation

RUN_SECONDS = 40.0
LINKS = (ufsook_link(), rs_fsk_link(), manchester_link(1))
LARGE = manchester_link(8)
SHARES = (0.1, 0.6, 0.3)
"""Of the packets; those of UFSOOK take the most frames."""
ROUNDS = 20
"""Of one lamp, of ten packets each."""
KEY = CommandKey(bytes(range(32)))
IMPAIRMENTS: dict[str, list[dict[str, Any]]] = {
    'SNR': [{'snr': snr} for snr in (3.0, 5.0, 8.0, 10.0, 15.0, 30.0)],
    'clock offset ppm': [{'clock_offset': ppm} for ppm in (-100.0, -30.0, 0.0, 30.0, 100.0)],
    'frames lost': [{'lost': share} for share in (0.0, 0.01, 0.03, 0.1)],
    'jitter s': [{'jitter': jitter} for jitter in (0.0, 50e-6, 100e-6, 200e-6)],
}
EXPOSURES = ((100, 20), (500, 60), (1000, 80), (2000, 100))
"""Of the global and of the rolling shutter [µs]."""
ROW_FACTORS = (0.6, 0.8, 1.0, 1.5, 2.0)
"""Rows that the lamp covers over those that the code states; the lamp is the nearer the more."""


def random_id(rng: np.random.Generator) -> IdPacket:
    """Return the packet of any ID."""
    return IdPacket(int(rng.integers(BEACON_ID_MAX + 1)))


def random_command(rng: np.random.Generator, beacon: int) -> CommandPacket:
    """Return a signed command of a beacon."""
    value = round(float(rng.uniform(-3.0, 3.0)), 6)
    return KEY.sign(Command(beacon, int(rng.choice(list(Operation))), value, int(rng.integers(1 << 32))))


def channels() -> dict[str, tuple[Channel | None, ...]]:
    """Return the impaired channels of each link, by name; None where a link has no such impairment."""
    found: dict[str, tuple[Channel | None, ...]] = {}
    for name, changes in IMPAIRMENTS.items():
        for change in changes:
            value = next(iter(change.values()))
            found[f'{name} {value:g}'] = tuple(replace(link.default_channel, **change) for link in LINKS)
    for of_global, of_rolling in EXPOSURES:
        exposures = (of_global, of_rolling, of_rolling)
        found[f'exposure µs {of_global}, rolling {of_rolling}'] = tuple(
            replace(link.default_channel, exposure=1e-6 * exposure)
            for link, exposure in zip(LINKS, exposures, strict=True)
        )
    for factor in ROW_FACTORS:
        usual = [link.default_channel for link in LINKS[1:]]
        rows = (replace(channel, rows=round(factor * channel.rows)) for channel in usual)
        found[f'rows × {factor:g}'] = (None, *rows)
    return found


def id_verdicts(link: Link, channel: Channel, lamps: int, seed: int) -> Counter[str]:
    """Return how many IDs are right, missed and wrong, over several lamps."""
    verdicts = Counter[str]()
    for lamp in range(lamps):
        rng = np.random.default_rng([seed, lamp])
        packet = random_id(rng)
        waveform = link.play([packet.to_bytes()], channel)
        got = link.simulate_reception(waveform, link.stamps(RUN_SECONDS, rng), channel, rng)
        # Slots of one play may be enough for two readings; that counts once.
        right = len({int(one.stamp / waveform.period) for one in got if one.packet == packet})
        # The last packet is known a little after its end; what the ends of a run cut off was not played whole.
        played = max(right, int(RUN_SECONDS / waveform.period - 1.0))
        verdicts += Counter(right=right, none=played - right, wrong=sum(one.packet != packet for one in got))
    return verdicts


def add_impairments(run: Run, lamps: int) -> None:
    """Add IDs right, missed and wrong for each code and impairment."""
    table = run.table('IDs with impairments', 'right / missed / wrong', *(link.name for link in LINKS))
    for name, of_links in progress(channels().items()):
        cells = []
        for link, channel in zip(LINKS, of_links, strict=True):
            cells.append(
                '–' if channel is None else outcomes(id_verdicts(link, channel, lamps, run.seed).elements())
            )
        table.add(name, *cells)


def add_latencies(run: Run, lamps: int) -> None:
    """Add how long a robot looks at a lamp until it has read the command."""
    table = run.table('Latency of a command', 'code', 'lamp plays', 's: median / 95 %', 'within 60 s')
    for link in (*LINKS, LARGE):
        channel = replace(link.default_channel, lost=0.01)
        for name, ids in (('command only', 0), ('ID, ID, command', 2)):
            waits = []
            for lamp in range(lamps):
                rng = np.random.default_rng([4, lamp])
                beacon = random_id(rng)
                command = random_command(rng, beacon.beacon)
                waveform = link.play([*[beacon.to_bytes()] * ids, command.to_bytes()], channel)
                stamps = link.stamps(60.0, rng)
                got = link.simulate_reception(waveform, stamps, channel, rng)
                waits.append(
                    min((each.stamp for each in got if each.packet == command), default=np.inf) - stamps[0]
                )
            read = int(np.isfinite(waits).sum())
            table.add(link.name, name, error(waits, '.1f', shown=(50, 95)), rate(read, lamps))


def random_channel(link: Link, rng: np.random.Generator) -> Channel:
    """Return a channel from good to hopeless."""
    return Channel(
        exposure=float(link.default_channel.exposure * rng.uniform(0.3, 1.7)),
        rows=round(link.default_channel.rows * float(rng.uniform(0.8, 1.5))),
        snr=float(np.exp(rng.uniform(np.log(2.0), np.log(20.0)))),
        clock_offset=float(rng.uniform(-100.0, 100.0)),
        jitter=float(rng.uniform(0.0, 150e-6)),
        lost=float(rng.uniform(0.0, 0.05)),
    )


def lamp_errors(job: tuple[int, int]) -> Counter[str]:
    """Return what happens at a lamp that plays its ID nine times and a command, again and again."""
    link, rng = LINKS[job[0]], np.random.default_rng([5, *job])
    channel, beacon = random_channel(link, rng), random_id(rng)
    command = random_command(rng, beacon.beacon)
    waveform = link.play([*[beacon.to_bytes()] * 9, command.to_bytes()], channel)
    confirmation, counts = IdConfirmation(), Counter(played=10 * ROUNDS)
    for got in link.simulate_reception(waveform, link.stamps(ROUNDS * waveform.period, rng), channel, rng):
        match got.packet:
            case IdPacket(beacon=heard):
                counts['id'] += heard != beacon.beacon
                counts['reported id'] += confirmation.add(heard) not in (None, beacon.beacon)
            case CommandPacket():
                counts['command'] += got.packet != command
                counts['signed command'] += got.packet != command and KEY.is_authentic(got.packet)
            case _:
                counts['id'] += 1
        counts['right'] += got.packet in (beacon, command)
    return counts


def add_errors(run: Run, packets: int) -> None:
    """Add what went wrong in many packets, SNR 2 to 20, under all impairments."""
    heads = 'IDs: single wrong', 'reported wrong', 'commands: single wrong', 'signed wrong'
    table = run.table('Wrong IDs and commands', 'code', 'read right', *heads)
    total = Counter[str]()
    for index, share in enumerate(SHARES):
        lamps = max(1, round(packets * share / (10 * ROUNDS)))
        counts = sum(
            in_processes(lamp_errors, [(index, k) for k in range(lamps)], LINKS[index].name), Counter[str]()
        )
        total += counts
        _add_errors(table, LINKS[index].name, counts)
    _add_errors(table, 'all', total)


def _add_errors(table: Any, name: str, counts: Counter[str]) -> None:
    wrong = ('id', 'reported id', 'command', 'signed command')
    played = counts['played']
    table.add(name, rate(counts['right'], played), *(rate(counts[kind], played, 'lower') for kind in wrong))


def add_times(run: Run) -> None:
    """Add how long decoders take for the lamps of a frame, frame by frame as a node does it, without the first 3 s."""
    table = run.table('Time of a frame', 'lamps in the frame', 'ms: median / 99 % / max')
    for link, lamps in ((LINKS[0], 4), (LINKS[1], 4), (LINKS[2], 2), (LARGE, 1)):
        rng = np.random.default_rng(6)
        stamps = link.stamps(60.0, rng)
        seen, decoders = [], [link.decoder(link.default_channel) for _ in range(lamps)]
        for beacon in (random_id(rng) for _ in range(lamps)):
            command = random_command(rng, beacon.beacon).to_bytes()
            waveform = link.play([beacon.to_bytes(), beacon.to_bytes(), command], link.default_channel)
            seen.append(camera_brightness(waveform, stamps, link.default_channel, rng))
        times = [
            sum(
                cpu_time(decode, stamps[k : k + 1], frames[k : k + 1])[1]
                for decode, frames in zip(decoders, seen, strict=True)
            )
            for k in range(len(stamps))
        ]
        rows = f' of {link.default_channel.rows} rows' if link.default_channel.rows else ''
        table.add(
            f'{lamps} {link.name}{rows}', time(times[round(3.0 * link.frame_rate) :], '.3f', (50, 99, 100))
        )


def main(run: Run, lamps: int, packets: int) -> None:
    """Measure the channel."""
    add_impairments(run, lamps)
    add_latencies(run, 5 * lamps)
    add_errors(run, packets)
    add_times(run)


if __name__ == '__main__':
    run_benchmark(
        main,
        lamps=Option(10, 1, 'of each impairment'),
        packets=Option(1_000_000, 4000, 'in which errors are counted'),
    )
