"""Attacks on the commands of light: `./shirube bench light_security [--share 0.01]`.

Forged, bit-flipped and replayed commands are judged one by one, with the lockout out of the way, for the lockout would
refuse them all. Among them are true commands, which must be accepted: a judge that refuses everything would be
safe too. Prints a table.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from tqdm import tqdm

from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.authorization.decision import Accepted
from vlc_beacon.core.packet.command_packet import (
    MAC_BYTES,
    Command,
    CommandPacket,
    Operation,
    read_command_packet,
)
from vlc_beacon.core.packet.crc import crc16
from vlc_beacon.core.settings import AuthorizationSettings
from vlc_beacon.files.counter_file import CounterFile
from vlc_beacon.files.key_file import make_key_file, read_key

ATTACKS = 1_000_000
TRUE_EVERY = 1000
"""A true command and, in the replays, a restart of the robot after so many attacks."""
PLACES = {beacon: (1.8 * (beacon % 8), 1.8 * (beacon // 8)) for beacon in range(64)}
# Wrong codes come one a second at most: the lockout needs a thousand of them in a second.
SETTINGS = AuthorizationSettings(bad_macs_max=1000, lockout_time=1.0)


@dataclass
class Robot:
    """A robot under attack, which drives from lamp to lamp.

    Attributes:
        key: that it shares with its host.
        counter_file: its memory.
        now: its clock [s].
        counter: counter of the last true command.
    """

    key: CommandKey
    counter_file: CounterFile
    now: float = 0.0
    counter: int = 1000
    authorizer: CommandAuthorizer = field(init=False)

    def __post_init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget all but the file."""
        self.authorizer = CommandAuthorizer(self.key, self.counter_file, PLACES, SETTINGS)

    def receive(self, packet: CommandPacket, speaker: int, place: tuple[float, float]) -> str:
        """Return what becomes of a packet: 'accepted' or the reason of the refusal."""
        self.now += 1.0
        self.authorizer.update_position(self.now, place)
        decision = self.authorizer.authorize(packet, speaker, self.now)
        return 'accepted' if isinstance(decision, Accepted) else decision.reason.value

    def true_command(self, rng: np.random.Generator) -> Command:
        """Return a command that the host has never sent before."""
        self.counter += 1
        operation, value = ((Operation.SLOW, 0.2), (Operation.TURN, -1.570796), (Operation.STOP, 0.0))[
            rng.integers(3)
        ]
        return Command(int(rng.integers(64)), operation, value, self.counter, bool(rng.integers(2)))


Attack = Callable[[Robot, Command, np.random.Generator], tuple[CommandPacket, int, tuple[float, float]]]


def forge(
    robot: Robot, old: Command, rng: np.random.Generator
) -> tuple[CommandPacket, int, tuple[float, float]]:
    """A command as it could come next, with a guessed code of authentication."""
    command = Command(
        old.beacon, int(rng.integers(1, 6)), old.value, robot.counter + 1, bool(rng.integers(2))
    )
    return CommandPacket(command, rng.bytes(MAC_BYTES)), command.beacon, PLACES[command.beacon]


def flip_bit(
    robot: Robot, old: Command, rng: np.random.Generator
) -> tuple[CommandPacket, int, tuple[float, float]]:
    """A true command with one to eight wrong bits, and a checksum that was made right again."""
    while True:
        content = bytearray(robot.key.sign(old).to_bytes()[:-2])
        for place in set(rng.integers(8 * len(content), size=rng.integers(1, 9)).tolist()):
            content[place // 8] ^= 1 << place % 8
        packet = read_command_packet(bytes(content) + crc16(bytes(content)).to_bytes(2))
        if packet is not None:
            beacon = packet.command.beacon
            return packet, beacon, PLACES.get(beacon, (0.0, 0.0))


def replay_later(
    robot: Robot, old: Command, rng: np.random.Generator
) -> tuple[CommandPacket, int, tuple[float, float]]:
    """A recorded command that another one has followed; a rule of the same counter would be in force still."""
    del rng
    return robot.key.sign(old), old.beacon, PLACES[old.beacon]


def repeat(
    robot: Robot, old: Command, rng: np.random.Generator
) -> tuple[CommandPacket, int, tuple[float, float]]:
    """A recorded one-shot command that no other one has followed."""
    del rng
    return robot.key.sign(replace(old, is_one_shot=True)), old.beacon, PLACES[old.beacon]


def replay_by_other_lamp(
    robot: Robot, old: Command, rng: np.random.Generator
) -> tuple[CommandPacket, int, tuple[float, float]]:
    """A command that was never received, recorded at one lamp and sent by another."""
    fresh = replace(old, counter=robot.counter + 1)
    other = (old.beacon + int(rng.integers(1, 64))) % 64
    return robot.key.sign(fresh), other, PLACES[other]


def replay_elsewhere(
    robot: Robot, old: Command, rng: np.random.Generator
) -> tuple[CommandPacket, int, tuple[float, float]]:
    """A command that was never received, sent by a copy of its lamp at another place."""
    fresh = replace(old, counter=robot.counter + 1)
    return robot.key.sign(fresh), old.beacon, PLACES[(old.beacon + int(rng.integers(1, 64))) % 64]


ATTACKS_BY_NAME: dict[str, tuple[Attack, bool]] = {
    'forged': (forge, False),
    'bits flipped, checksum made right': (flip_bit, False),
    'old counter': (replay_later, False),
    'old counter, after a restart': (replay_later, True),
    'the last one-shot command again, after a restart': (repeat, True),
    'sent by another beacon': (replay_by_other_lamp, False),
    'outside the zone of the beacon': (replay_elsewhere, False),
}


def attack(
    robot: Robot, kind: Attack, count: int, seed: int, *, restarts: bool
) -> Iterator[tuple[bool, str]]:
    """Yield for every packet whether it was a true one, and what became of it."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        if k % TRUE_EVERY == 0:
            old = robot.true_command(rng)
            if kind is repeat:
                old = replace(old, is_one_shot=True)
            yield True, robot.receive(robot.key.sign(old), old.beacon, PLACES[old.beacon])
            if kind is replay_later:
                robot.counter += 1
                newer = replace(old, counter=robot.counter)
                yield True, robot.receive(robot.key.sign(newer), newer.beacon, PLACES[newer.beacon])
            if restarts:
                robot.restart()
        yield False, robot.receive(*kind(robot, old, rng))


def main() -> int:
    """Prints what became of the attacks."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else '')
    parser.add_argument('--share', type=float, default=1.0, help='of the million attacks of each kind')
    count = max(TRUE_EVERY, round(ATTACKS * parser.parse_args().share))
    print('| attack | decisions | accepted | rejected as | true commands accepted |\n|---|---|---|---|---|')
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        make_key_file(Path(folder) / 'key')
        counter_file = CounterFile(Path(folder) / 'counters.json')
        counter_file.reset(0)
        robot = Robot(read_key(Path(folder) / 'key'), counter_file)
        for seed, (name, (kind, restarts)) in enumerate(ATTACKS_BY_NAME.items()):
            outcomes = {True: Counter[str](), False: Counter[str]()}
            packets = attack(robot, kind, count, seed, restarts=restarts)
            for is_true, outcome in tqdm(packets, total=count, desc=name, leave=False):
                outcomes[is_true][outcome] += 1
            refusals = ', '.join(
                f'{outcome} {n}' for outcome, n in outcomes[False].most_common() if outcome != 'accepted'
            )
            accepted, true = outcomes[False]['accepted'], outcomes[True]
            wrong += accepted + true.total() - true['accepted']
            print(
                f'| {name} | {count} | {accepted} | {refusals} | {true["accepted"]} of {true.total()} |',
                flush=True,
            )
    chance = 2 * count / 2.0 ** (8 * MAC_BYTES)
    print(
        f'\nBy chance {chance:.1g} of the forged and flipped ones would have been accepted: their code has 32 bits.'
    )
    return 1 if wrong else 0


if __name__ == '__main__':
    raise SystemExit(main())
