"""The protocol of firmware/motor_controller: checksums, and an auto-stop that can be set."""

import re

from motor_bridge.core.checksum import with_checksum, without_checksum
from motor_bridge.emulator.firmware import Firmware

_AUTO_STOP = 200, 2000  # range [ms]


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
        text = without_checksum(line) if b'*' in line else line
        if text is not line:
            self._is_checksummed |= text is not None
        elif self._is_checksummed and line != b'm 0 0':
            self._is_checksummed = line != b'b'
            text = None if self._is_checksummed else line
        auto_stop = re.fullmatch(rb'h (\d{1,5})', text or b'')
        if auto_stop and _AUTO_STOP[0] <= int(auto_stop[1]) <= _AUTO_STOP[1]:
            self._auto_stop, reply = 1e-3 * int(auto_stop[1]), b'OK'
        else:
            reply = super().receive((text or b'') + b'\r').removesuffix(b'\r\n')
        return (with_checksum(reply) if self._is_checksummed else reply) + b'\r\n'
