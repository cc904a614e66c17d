"""The recorded drive in a loop through the live node: does memory grow, is a message lost, how late are poses?

The bag is played in real time, by default once a minute for an hour. The loop makes the clock jump back, so each
round begins with a search of the whole map.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from time import monotonic

import numpy as np
from _figures import count, measured, rate, time
from _harness import Option, Run, run_benchmark

from shirube_bags.bag_reader import BagReader
from shirube_bags.stamps import NANOSECONDS
from shirube_cli.floor_replay import IMAGES, LOCALIZER
from shirube_cli.live_localizer import LiveLocalizer, live_localizer
from shirube_cli.project import find_root
from shirube_cli.workspace import build_workspace

SAMPLE_INTERVAL = 10.0  # between looks at the node's memory [s]
COUNTED = {'/image_raw/compressed': '/image_raw/compressed', '/camera_info': 'camera_info', '/odom': 'odom'}
"""Topics of the bag and the names under which the node's diagnostics count them."""


class MemoryRecord:
    """The node's resident memory over time."""

    def __init__(self, live: LiveLocalizer) -> None:
        """Begin now."""
        self._status = Path('/proc') / str(live.process.pid) / 'status'
        self._start = self._next = monotonic()
        self.minutes: list[float] = []
        self.megabytes: list[float] = []

    def look(self) -> None:
        """Take a sample if it is time."""
        now = monotonic()
        if now < self._next:
            return
        self._next += SAMPLE_INTERVAL
        resident = next(x for x in self._status.read_text().splitlines() if x.startswith('VmRSS:'))
        self.minutes.append((now - self._start) / 60.0)
        self.megabytes.append(int(resident.split()[1]) / 1024.0)


def main(run: Run, rounds: int, rate_factor: float) -> None:
    """Play the bag and add what was seen."""
    bag = find_root() / 'bags' / 'floor_drive'
    build_workspace(find_root())
    with (
        tempfile.TemporaryDirectory() as folder,
        live_localizer(find_root(), LOCALIZER, IMAGES, Path(folder)) as live,
    ):
        memory = MemoryRecord(live)
        live.play(bag, ['--rate', str(rate_factor), '--loop', str(rounds)], memory.look)
        live.listen_for_diagnostics()
        live.end()
    table = run.table('Memory', 'minute', 'resident memory of the node MB')
    for index in np.linspace(0, len(memory.minutes) - 1, 6).astype(int):
        table.add(f'{memory.minutes[index]:.1f}', measured(memory.megabytes[index], '.1f'))
    half = len(memory.minutes) // 2
    if half > 1:
        slope = np.polyfit(memory.minutes[half:], memory.megabytes[half:], 1)[0]
        run.note(f'Growth over the second half: {60.0 * slope:+.2f} MB an hour.')
    said = live.listener.diagnostics
    table = run.table('Messages', 'topic', 'arrived')
    with BagReader(bag) as reader:
        for topic, name in COUNTED.items():
            table.add(topic, rate(int(said[f'{name} received']), rounds * reader.topics[topic].message_count))
    published = int(said['images with a fix'])
    table.add('~/pose', rate(live.listener.pose_count, published))
    table = run.table('Images without a pose', 'reason', 'number')
    for reason, number in live.listener.reasons().items():
        table.add(reason, count(number))
    delays = 1e3 * np.array(live.listener.delays) / NANOSECONDS
    run.table('Latency', 'poses', 'from an image to its pose ms: median / 99 % / max').add(
        str(len(delays)), time(delays, '.1f', (50, 99, 100))
    )


if __name__ == '__main__':
    run_benchmark(
        main,
        rounds=Option(60, 1, 'so often the bag is played'),
        rate_factor=Option(1.0, 3.0, 'of the replay'),
    )
