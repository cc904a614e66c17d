"""The recorded drive in a loop through the live node: does memory grow, is a message lost, how late are poses?

    shirube bench soak --rounds 60

The bag is played in real time, by default once a minute for an hour. The loop makes the clock jump back, so
each round begins with a search of the whole map. The bag's images are small; whoever wants to know more puts
a separate bag.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from time import monotonic

import numpy as np
from numpy.typing import NDArray

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

    def growth(self) -> float:
        """Return the slope of a line through the second half of the samples [MB/h]."""
        half = len(self.minutes) // 2
        slope = np.polyfit(self.minutes[half:], self.megabytes[half:], 1)[0]
        return float(60.0 * slope)


def print_memory(memory: MemoryRecord) -> None:
    """Print a table of the memory at six times, and its growth."""
    print('| minute | resident memory of the node MB |\n|---|---|')
    for index in np.linspace(0, len(memory.minutes) - 1, 6).astype(int):
        print(f'| {memory.minutes[index]:.1f} | {memory.megabytes[index]:.1f} |')
    print(f'\nGrowth over the second half: {memory.growth():+.2f} MB an hour.\n')


def print_messages(live: LiveLocalizer, bag: Path, rounds: int) -> None:
    """Print how many messages were played and how many the node and the listener got."""
    with BagReader(bag) as reader:
        played = {topic: rounds * reader.topics[topic].message_count for topic in COUNTED}
    said = live.listener.diagnostics
    print('| topic | played | received by the node | lost |\n|---|---|---|---|')
    for topic, name in COUNTED.items():
        received = int(said[f'{name} received'])
        print(f'| `{topic}` | {played[topic]} | {received} | {played[topic] - received} |')
    published, arrived = int(said['images with a fix']), live.listener.pose_count
    print(f'| `~/pose` | {published} published | {arrived} by the listener | {published - arrived} |')
    print('\nImages without a pose: ', end='')
    print(', '.join(f'{number} x "{reason}"' for reason, number in live.listener.reasons().items()) or 'none')


def print_latency(delays: NDArray[np.float64]) -> None:
    """Print the time from an image to its pose, ``delays`` in seconds, shape (n,)."""
    median, late, worst = 1e3 * np.percentile(delays, [50.0, 99.0, 100.0])
    print(
        f'\nFrom the publication of an image to that of its pose: {median:.1f} ms (median), {late:.1f} ms (99 %), '
        f'{worst:.1f} ms (longest) of {len(delays)}.'
    )


def main() -> None:
    """Run the soak and print its tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--rounds', type=int, default=60, help='so often the bag is played')
    parser.add_argument('--bag', type=Path, default=find_root() / 'bags' / 'floor_drive')
    arguments = parser.parse_args()
    build_workspace(find_root())
    with (
        tempfile.TemporaryDirectory() as folder,
        live_localizer(find_root(), LOCALIZER, IMAGES, Path(folder)) as live,
    ):
        memory = MemoryRecord(live)
        live.play(arguments.bag, ['--rate', '1', '--loop', str(arguments.rounds)], memory.look)
        live.listen_for_diagnostics()
        live.end()
    print_memory(memory)
    print_messages(live, arguments.bag, arguments.rounds)
    print_latency(np.array(live.listener.delays) / NANOSECONDS)


if __name__ == '__main__':
    main()
