"""What goes wrong at lamps for `light_channel`: wrong IDs, wrong commands, and what only the checksum let pass."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from _light_links import Channel, Link, manchester_link, rs_fsk_link, ufsook_link

from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.packet.command_packet import Command, CommandPacket, Operation
from vlc_beacon.core.packet.id_packet import BEACON_ID_MAX, IdPacket
from vlc_beacon.core.receiver.tracked_lamp import IdConfirmation

KEY = CommandKey(bytes(range(32)))
LINKS = (ufsook_link(), rs_fsk_link(), manchester_link(1))
ROUNDS = 20
"""Of one lamp, of ten packets each."""


def random_id(rng: np.random.Generator) -> IdPacket:
    """Return the packet of any ID."""
    return IdPacket(int(rng.integers(BEACON_ID_MAX + 1)))


def random_command(rng: np.random.Generator, beacon: int) -> CommandPacket:
    """Return a signed command of a beacon."""
    value = round(float(rng.uniform(-3.0, 3.0)), 6)
    return KEY.sign(Command(beacon, int(rng.choice(list(Operation))), value, int(rng.integers(1 << 32))))


@dataclass(frozen=True)
class Errors:
    """What went wrong among packets, as counts.

    Attributes:
        played: packets.
        right: read right.
        id_misses: single ID packets that were wrong though their checksum was right.
        wrong_ids: IDs reported that were wrong.
        command_misses: single commands that were wrong though their checksum was right.
        wrong_commands: wrong commands with a right code of authentication.
    """

    sent: int = 0
    right: int = 0
    id_misses: int = 0
    wrong_ids: int = 0
    command_misses: int = 0
    wrong_commands: int = 0

    def __add__(self, other: Errors) -> Errors:
        """Return both together."""
        pairs = zip(self.__dict__.values(), other.__dict__.values(), strict=True)
        return Errors(*(a + b for a, b in pairs))

    def cells(self) -> str:
        """Return the counts as cells of a table."""
        return ' | '.join(str(count) for count in self.__dict__.values())


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


def lamp_errors(link_index: int, seed: int) -> Errors:
    """Return what happens at a lamp that plays its ID nine times and a command, again and again."""
    link, rng = LINKS[link_index], np.random.default_rng([5, link_index, seed])
    channel, beacon = random_channel(link, rng), random_id(rng)
    command = random_command(rng, beacon.beacon)
    waveform = link.play([*[beacon.to_bytes()] * 9, command.to_bytes()], channel)
    confirmation = IdConfirmation()
    counts = Counter[str]()
    for got in link.simulate_reception(waveform, link.stamps(ROUNDS * waveform.period, rng), channel, rng):
        match got.packet:
            case IdPacket(beacon=heard):
                counts['id'] += heard != beacon.beacon
                counts['wrong id'] += confirmation.add(heard) not in (None, beacon.beacon)
            case CommandPacket():
                counts['command'] += got.packet != command
                counts['wrong command'] += got.packet != command and KEY.is_authentic(got.packet)
            case _:
                counts['id'] += 1
        counts['right'] += got.packet in (beacon, command)
    kinds = ('right', 'id', 'wrong id', 'command', 'wrong command')
    return Errors(10 * ROUNDS, *(counts[kind] for kind in kinds))
