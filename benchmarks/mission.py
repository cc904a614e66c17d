"""The mission from several seeds, one after the other: `./shirube bench mission [--seeds 20] [--first 0]`.

Prints a row for each: the three goals, the errors there, the room to the nearest thing, collisions, way and times. A
mission that ended before its end has a row, too, and its reason below. Logs and summaries stay in a folder.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

HEADER = (
    '| seed | goals | true pose off mm | fused pose off mm | rms of the fused pose mm | least room mm | collisions '
    '| way m | simulated s | wall s: start, drive |'
)


def main() -> int:
    """Run the missions and print the table; return 0 if all succeeded, else 1."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', type=int, default=20, help='how many (default: %(default)s)')
    parser.add_argument('--first', type=int, default=0, help='the first one (default: %(default)s)')
    parser.add_argument('--folder', type=Path, default=Path('out/missions'), help='default: %(default)s')
    options = parser.parse_args()
    print(f'{HEADER}\n{"|---" * (HEADER.count("|") - 1)}|', flush=True)
    failures = {}
    for seed in range(options.first, options.first + options.seeds):
        fault = run(seed, options.folder)
        summary = read_summary(options.folder / str(seed))
        if summary is not None:
            print(row(summary), flush=True)
        if summary is None or not summary['success']:
            failures[seed] = fault if summary is None else reason(summary)
    print(f'\n{options.seeds - len(failures)} of {options.seeds} succeeded.')
    for seed, why in failures.items():
        print(f'Seed {seed}: {why}')
    return 1 if failures else 0


def run(seed: int, folder: Path) -> str:
    """Run one mission; return what it said last."""
    place = folder / str(seed)
    (place / 'summary.json').unlink(missing_ok=True)
    command = [sys.executable, '-m', 'shirube_mission.commands.room', str(place), '--seed', str(seed)]
    command += ['--building', str(folder / 'building')]
    said = subprocess.run(command, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return said.stdout.strip().rpartition('\n')[2]


def read_summary(folder: Path) -> dict[str, Any] | None:
    """Return the summary of a mission, None if it did not come to its end."""
    path = folder / 'summary.json'
    if not path.exists():
        return None
    summary: dict[str, Any] = json.loads(path.read_text())
    return summary


def reason(summary: dict[str, Any]) -> str:
    """Return why a mission is no success."""
    bad = [str(number) for number, goal in enumerate(summary['goals'], start=1) if not goal['good']]
    touched = f'; {summary["collisions"]} collisions' if summary['collisions'] else ''
    return f'{summary["ended"]}{"; not good: goal " + ", ".join(bad) if bad else ""}{touched}'


def row(summary: dict[str, Any]) -> str:
    """Return a mission's row of the table."""
    goals, timing = summary['goals'], summary['timing']
    cells = [
        str(summary['seed']),
        f'{sum(goal["good"] for goal in goals)} of 3',
        ' / '.join(f'{1e3 * goal["true_error"]:.1f}' for goal in goals),
        ' / '.join(f'{1e3 * goal["fused_error"]:.1f}' for goal in goals),
        f'{1e3 * summary["poses"]["pose_arbiter"]["rmse"]:.1f}',
        f'{1e3 * summary["least_clearance"]:.0f}',
        str(summary['collisions']),
        f'{summary["path_length"]:.1f}',
        f'{summary["seconds"]:.0f}',
        f'{timing["start"]:.0f}, {timing["drive"]:.0f}',
    ]
    return f'| {" | ".join(cells)} |'


if __name__ == '__main__':
    sys.exit(main())
