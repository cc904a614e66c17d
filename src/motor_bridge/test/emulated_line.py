"""A line without faults to an emulated controller, in memory."""

import numpy as np

from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings


class EmulatedLine:
    """Replies at once; ``damage`` replaces commands, once each, and ``replies`` the next replies."""

    def __init__(self, firmware, slowest_reply=0.0):
        settings = EmulatorSettings(encoder_noise=0.0, slip_sigma=0.0, firmware=firmware)
        self.controller = EmulatedController(settings, np.random.default_rng(1))
        self.slowest_reply = slowest_reply
        self.damage, self.replies, self._received = {}, [], b''

    def write(self, data):
        damaged = self.damage.get(data)
        reply = self.controller.receive(damaged.pop() if damaged else data)
        self._received += self.replies.pop() if self.replies else reply

    def read_line(self, size_max):
        line, _, self._received = self._received.partition(b'\n')
        return line + b'\n' if line else b''

    def discard_received(self):
        count, self._received = len(self._received), b''
        return count

    drain = discard_received

    def set_latency(self, latency):
        pass
