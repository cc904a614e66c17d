"""The floor demo: the recorded drive through the live node, compared with the true drive."""

import html
import json
import math
import platform
import sys
from collections.abc import Sequence
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np

from floor_localizer.files.dot_map_file import load_dot_map
from floor_localizer.localization.localizer_from_map_file import NodeSettings
from shirube_bags.accuracy import exceeded_limits, format_report, report_to_dict
from shirube_bags.stamps import NANOSECONDS
from shirube_cli.floor_picture import draw_floor_picture
from shirube_cli.floor_replay import FloorAccuracy, FloorReplay, measure_accuracy, replay_floor_drive
from shirube_core.files import write_text


def figures_as_text(replay: FloorReplay, accuracy: FloorAccuracy) -> str:
    """Return the figures as a few lines for people."""
    recorded = float(accuracy.images_ns[-1] - accuracy.images_ns[0]) / NANOSECONDS
    median, p95 = 1e3 * np.quantile(replay.delays, [0.5, 0.95])
    lines = [
        format_report(accuracy.report),
        f'from an image to its pose: {median:.1f} ms (median), {p95:.1f} ms (95 %)',
        f'replayed {recorded:.1f} s in {replay.duration:.1f} s: {recorded / replay.duration:.1f} x real time',
    ]
    if replay.reasons:
        reasons = ', '.join(f'{number} x {reason}' for reason, number in replay.reasons.items())
        lines.append(f'images without a pose: {reasons}')
    return '\n'.join(lines)


def sentence_on_limits(broken: Sequence[str]) -> str:
    """Return the verdict in a sentence."""
    return f'Outside the limits: {"; ".join(broken)}.' if broken else 'Within all limits.'


def page(bag: str, figures: str, broken: Sequence[str]) -> str:
    """Return the report as an HTML page for a folder with `track.png`, with the limits that were not kept."""
    packages = ', '.join(f'{name} {version(name)}' for name in ('numpy', 'scipy', 'opencv-python-headless', 'numba'))
    values = {
        'bag': bag,
        'verdict': 'failed' if broken else 'passed',
        'sentence': sentence_on_limits(broken),
        'figures': figures,
        'machine': f'{platform.platform()}, {processor_name()}, Python {sys.version.split()[0]}, {packages}',
    }
    template = Template((files('shirube_cli') / 'floor_report.html').read_text())
    return template.substitute({name: html.escape(value) for name, value in values.items()})


def processor_name() -> str:
    """Return the processor's name; Python itself does not know it on Linux."""
    for line in Path('/proc/cpuinfo').read_text().splitlines():
        if line.startswith('model name'):
            return line.split(':', 1)[1].strip()
    return platform.machine()


# What must come out, with room for the rounding of other versions; lengths in metres, angles in radians.
LIMITS = {
    'coverage': 0.99,
    'position_median': 0.00005,
    'position_p95': 0.00015,
    'position_max': 0.001,
    'heading_p95': math.radians(0.1),
    'heading_max': math.radians(0.3),
}


def demo_floor(root: Path, folder: Path, bag: Path | None = None) -> int:
    """Replay the drive, or another bag of this floor, through the live node, and leave a report in the folder.

    Prints the accuracy. Returns 0 when the result is within the limits, else 1.

    Raises:
        CommandError: a process failed.
    """
    bag = bag or root / 'bags' / 'floor_drive'
    print(f'Replaying {bag} through the live floor_localizer ...', file=sys.stderr)
    replay = replay_floor_drive(root, bag, folder)
    accuracy = measure_accuracy(replay, bag)
    broken = exceeded_limits(accuracy.report, LIMITS)
    figures = figures_as_text(replay, accuracy)
    draw_floor_picture(folder / 'track.png', accuracy, load_dot_map(NodeSettings().map_path).points)
    write_text(folder / 'report.html', page(bag.name, figures, broken))
    write_text(folder / 'accuracy.json', json.dumps(report_to_dict(accuracy.report), indent=2) + '\n')
    print(f'{figures}\n{sentence_on_limits(broken)}\nReport: {folder / "report.html"}')
    return 1 if broken else 0
