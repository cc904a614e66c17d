"""The floor demo: the recorded drive through the live node, compared with the true drive."""

import json
import math
import sys
from pathlib import Path

from floor_localizer.files.dot_map_file import load_dot_map
from floor_localizer.localization.localizer_from_map_file import NodeSettings
from shirube_bags.accuracy_report import exceeded_limits, report_to_dict
from shirube_cli.floor_accuracy import measure_accuracy
from shirube_cli.floor_picture import draw_floor_picture
from shirube_cli.floor_replay import replay_floor_drive
from shirube_cli.floor_report import figures_as_text, page, sentence_on_limits
from shirube_core.files import write_text

# What must come out, with room for the rounding of other versions; lengths in metres, angles in radians.
LIMITS = {
    'coverage': 0.99,
    'position_median': 0.00005,
    'position_p95': 0.00015,
    'position_max': 0.001,
    'heading_p95': math.radians(0.1),
    'heading_max': math.radians(0.3),
}


def demo_floor(root: Path, folder: Path) -> int:
    """Replay the drive through the live node, print the accuracy and leave the report in the folder.

    Returns:
        0 when the result is within the limits, 1 otherwise.

    Raises:
        CommandError: a process failed.
    """
    bag = root / 'bags' / 'floor_drive'
    print(f'Replaying {bag.relative_to(root)} through the live floor_localizer ...', file=sys.stderr)
    replay = replay_floor_drive(root, bag, folder)
    accuracy = measure_accuracy(replay, bag)
    broken = exceeded_limits(accuracy.report, LIMITS)
    figures = figures_as_text(replay, accuracy)
    draw_floor_picture(folder / 'track.png', accuracy, load_dot_map(NodeSettings().map_path).points)
    write_text(folder / 'report.html', page(bag.name, 'track.png', figures, broken))
    write_text(folder / 'accuracy.json', json.dumps(report_to_dict(accuracy.report), indent=2) + '\n')
    print(f'{figures}\n{sentence_on_limits(broken)}\nReport: {folder / "report.html"}')
    return 1 if broken else 0
