"""Shared secret of host and robot, and the message authentication code (MAC)."""

import hashlib
import hmac

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
