"""The mission from several seeds, one after the other: `./shirube bench mission [--seeds 20] [--first 0] [--resume]`.

Prints a row for each: the three goals, the errors there, the largest error of the fused pose on the way, the room to
the nearest thing, collisions, way and times; below them median and worst. A mission that ended before its end has a
row, too, and its reason below. Logs and figures stay in a folder, written as each mission ends: what was interrupted
goes on with `--resume`, which drives only the missions that have no figures there.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from shirube_cli.child_process import child_process

Summary = dict[str, Any]

HEADER = (
    '| seed | goals | true pose off at them mm | fused pose off at them mm | rms of the fused pose mm '
    '| its largest error mm | least room mm | collisions | way m | simulated s | wall s: start, drive |'
)


def main() -> int:
    """Run the missions and print the table; return 0 if all succeeded, else 1."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', type=int, default=20, help='how many (default: %(default)s)')
    parser.add_argument('--first', type=int, default=0, help='the first one (default: %(default)s)')
    parser.add_argument('--folder', type=Path, default=Path('out/missions'), help='default: %(default)s')
    parser.add_argument('--resume', action='store_true', help='keep the figures that stand in the folder')
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    if not options.resume:
        for seed in seeds:
            (options.folder / str(seed) / 'summary.json').unlink(missing_ok=True)
    print(f'{HEADER}\n{"|---" * (HEADER.count("|") - 1)}|', flush=True)
    summaries, failures = list[Summary](), dict[int, str]()
    for seed in seeds:
        fault = '' if read_summary(options.folder / str(seed)) else run(seed, options.folder)
        summary = read_summary(options.folder / str(seed))
        if summary is not None:
            print(row(summary), flush=True)
            summaries.append(summary)
        if summary is None or not summary['success']:
            failures[seed] = fault if summary is None else reason(summary)
            print(f'Seed {seed}: {failures[seed]}', file=sys.stderr, flush=True)
    print_sums(summaries)
    print(f'\n{len(seeds) - len(failures)} of {len(seeds)} succeeded.')
    for seed, why in failures.items():
        print(f'Seed {seed}: {why}')
    return 1 if failures else 0


def run(seed: int, folder: Path) -> str:
    """Run one mission; return what it said last."""
    place = folder / str(seed)
    place.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, '-m', 'shirube_bringup.commands.room', str(place)]
    command += ['--seed', str(seed), '--building', str(folder / 'building')]
    # An interrupted mission must have the time to end its nodes.
    with child_process(command, os.environ, place / 'mission.log') as mission:
        mission.wait()
    return (place / 'mission.log').read_text().strip().rpartition('\n')[2]


def read_summary(folder: Path) -> Summary | None:
    """Return the summary of a mission, None where there is none."""
    path = folder / 'summary.json'
    if not path.exists():
        return None
    summary: Summary = json.loads(path.read_text())
    return summary


def reason(summary: Summary) -> str:
    """Return why a mission is no success."""
    bad = [str(number) for number, goal in enumerate(summary['goals'], start=1) if not goal['good']]
    touched = f'; {summary["collisions"]} collisions' if summary['collisions'] else ''
    return f'{summary["ended"]}{"; not good: goal " + ", ".join(bad) if bad else ""}{touched}'


def row(summary: Summary) -> str:
    """Return a mission's row of the table."""
    goals, timing, fused = summary['goals'], summary['timing'], summary['poses']['pose_arbiter']
    cells = [
        str(summary['seed']),
        f'{sum(goal["good"] for goal in goals)} of 3',
        ' / '.join(f'{1e3 * goal["true_error"]:.1f}' for goal in goals),
        ' / '.join(f'{1e3 * goal["fused_error"]:.1f}' for goal in goals),
        f'{1e3 * fused["rmse"]:.1f}' if fused['count'] else '–',
        f'{1e3 * fused["worst"]:.1f}' if fused['count'] else '–',
        f'{1e3 * summary["least_clearance"]:.0f}',
        str(summary['collisions']),
        f'{summary["path_length"]:.1f}',
        f'{summary["seconds"]:.0f}',
        f'{timing["start"]:.0f}, {timing["drive"]:.0f}',
    ]
    return f'| {" | ".join(cells)} |'


def print_sums(summaries: Sequence[Summary]) -> None:
    """Print median and worst of all missions that have figures."""
    with_poses = [summary for summary in summaries if summary['poses']['pose_arbiter']['count']]
    if not with_poses:
        return

    def line(name: str, of: Callable[[list[float]], float], least: Callable[[list[float]], float]) -> str:
        goals = [goal for summary in with_poses for goal in summary['goals']] or [
            {'true_error': 0.0, 'fused_error': 0.0}
        ]
        fused = [summary['poses']['pose_arbiter'] for summary in with_poses]
        cells = [
            name,
            '',
            *(f'{1e3 * of([goal[key] for goal in goals]):.1f}' for key in ('true_error', 'fused_error')),
            *(f'{1e3 * of([pose[key] for pose in fused]):.1f}' for key in ('rmse', 'worst')),
            f'{1e3 * least([summary["least_clearance"] for summary in with_poses]):.0f}',
            f'{of([summary["collisions"] for summary in with_poses]):.0f}',
            f'{of([summary["path_length"] for summary in with_poses]):.1f}',
            f'{of([summary["seconds"] for summary in with_poses]):.0f}',
            ', '.join(
                f'{of([summary["timing"][key] for summary in with_poses]):.0f}' for key in ('start', 'drive')
            ),
        ]
        return f'| {" | ".join(cells)} |'

    print(line('median', statistics.median, statistics.median))
    print(line('worst', max, min))


if __name__ == '__main__':
    sys.exit(main())
