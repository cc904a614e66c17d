"""Keys of the senders of commands, and their counters."""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from vlc_beacon.core.packet.command_packet import MAC_BYTES, Command, CommandPacket
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

KEY_BYTES_MIN = 16
KEY_BYTES_MAX = hashlib.blake2s.MAX_KEY_SIZE


class CommandKey:
    """Signs and verifies commands with keyed BLAKE2s (RFC 7693) of `MAC_BYTES` bytes.

    Args:
        secret: random bytes, `KEY_BYTES_MIN` to `KEY_BYTES_MAX`.

    Raises:
        VlcBeaconError: the secret is too short or too long.
    """

    def __init__(self, secret: bytes) -> None:
        if not KEY_BYTES_MIN <= len(secret) <= KEY_BYTES_MAX:
            raise VlcBeaconError(f'key has {len(secret)} bytes, it must have {KEY_BYTES_MIN} to {KEY_BYTES_MAX}')
        self._secret = secret

    def sign(self, command: Command) -> CommandPacket:
        """Return the signed packet of a command."""
        return CommandPacket(command, self._compute_mac(command))

    def is_authentic(self, packet: CommandPacket) -> bool:
        """Return whether the packet's command was signed with this key."""
        return hmac.compare_digest(self._compute_mac(packet.command), packet.mac)

    def _compute_mac(self, command: Command) -> bytes:
        return hashlib.blake2s(command.signed_bytes(), key=self._secret, digest_size=MAC_BYTES).digest()


@dataclass(frozen=True)
class Counters:
    """The last accepted counters.

    Attributes:
        floor: initial last counter of all beacons.
        zone_rules: last counter of zone rules by beacon ID.
        one_shots: last counter of one-shot commands by beacon ID.
    """

    floor: int = 0
    zone_rules: Mapping[int, int] = field(default_factory=dict)
    one_shots: Mapping[int, int] = field(default_factory=dict)

    def last_counter(self, command: Command) -> int:
        """Return the last counter of the command's beacon and kind."""
        seen = self.one_shots if command.is_one_shot else self.zone_rules
        return seen.get(command.beacon, self.floor)

    def is_new(self, command: Command) -> bool:
        """Return whether a command is not a replay."""
        return command.counter >= self.last_counter(command) + command.is_one_shot

    def advance(self, command: Command) -> Counters:
        """Return the counters after an accepted command."""
        if command.is_one_shot:
            return replace(self, one_shots={**self.one_shots, command.beacon: command.counter})
        return replace(self, zone_rules={**self.zone_rules, command.beacon: command.counter})


class CounterStore(Protocol):
    """Persistent storage of counters."""

    def read(self) -> Counters:
        """Return the counters; raises `VlcBeaconError` if they cannot be read."""

    def write(self, counters: Counters) -> None:
        """Store the counters; raises `VlcBeaconError` if they cannot be stored."""
