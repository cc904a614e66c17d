"""The protocol of firmware/motor_controller: checksums, and an auto-stop that can be set."""

from __future__ import annotations

from motor_bridge.core.checksum import with_checksum, without_checksum
from motor_bridge.emulator.firmware import Firmware, atoi

_AUTO_STOP = 200, 2000  # range [ms]
_END = b'\r\n'


class ChecksummedFirmware(Firmware):
    """Firmware that replies with checksums from the first valid one on, and then refuses plain lines."""

    def reset(self) -> None:
        """Restart as after power on: without checksums."""
        super().reset()
        self._partial_line, self._is_checksummed = b'', False

    def receive(self, data: bytes) -> bytes:
        """Receive bytes and return the replies."""
        *lines, self._partial_line = (self._partial_line + data).split(b'\r')
        return b''.join(map(self._reply, lines))

    def _reply(self, line: bytes) -> bytes:
        text = self._accept(line)
        if text is None:
            reply = b'Invalid Command'
        elif text[:2] == b'h ' and _AUTO_STOP[0] <= atoi(text[2:].decode('latin-1')) <= _AUTO_STOP[1]:
            self._auto_stop = 1e-3 * atoi(text[2:].decode('latin-1'))
            reply = b'OK'
        else:
            reply = super().receive(text + b'\r').removesuffix(_END)
        return (with_checksum(reply) if self._is_checksummed else reply) + _END

    def _accept(self, line: bytes) -> bytes | None:
        """Return the text of a line that is to be executed, or None."""
        if b'*' in line:
            text = without_checksum(line)
            self._is_checksummed |= text is not None
            return text
        if line == b'b':
            self._is_checksummed = False
        return line if not self._is_checksummed or line == b'm 0 0' else None
