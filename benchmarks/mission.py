"""The mission of six nodes from several seeds, one after the other: goals, errors, collisions, times.

Logs and figures stay in a folder, written as each mission ends: what was interrupted goes on with ``--resume``, which
drives only the missions that have no figures there.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any

from _figures import count, error, measured, rate
from _harness import MissingError, Option, Run, progress, run_benchmark

from shirube_cli.project import child_process

FOLDER = Path('out/missions')
Summary = dict[str, Any]


def drive(seed: int) -> str:
    """Run one mission; return what it said last."""
    place = FOLDER / str(seed)
    place.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, '-m', 'shirube_bringup.commands.room', str(place)]
    command += ['--seed', str(seed), '--building', str(FOLDER / 'building')]
    # An interrupted mission must have the time to end its nodes.
    with child_process(command, os.environ, place / 'mission.log') as mission:
        mission.wait()
    return (place / 'mission.log').read_text().strip().rpartition('\n')[2]


def read_summary(seed: int) -> Summary | None:
    """Return the summary of a mission, None where there is none."""
    path = FOLDER / str(seed) / 'summary.json'
    return json.loads(path.read_text()) if path.exists() else None


def reason(summary: Summary) -> str:
    """Return why a mission is no success."""
    bad = [str(number) for number, goal in enumerate(summary['goals'], start=1) if not goal['good']]
    touched = f'; {summary["collisions"]} collisions' if summary['collisions'] else ''
    return f'{summary["ended"]}{"; not good: goal " + ", ".join(bad) if bad else ""}{touched}'


def main(run: Run, seeds: int, first: int, resume: bool) -> None:
    """Run the missions."""
    if seeds == 0:
        raise MissingError('a mission takes minutes; not in a quick run')
    chosen = range(first, first + seeds)
    summaries = list[Summary]()
    for seed in progress(chosen, 'missions'):
        if not resume:
            (FOLDER / str(seed) / 'summary.json').unlink(missing_ok=True)
        fault = '' if read_summary(seed) else drive(seed)
        summary = read_summary(seed)
        if summary is not None:
            summaries.append(summary)
        if summary is None or not summary['success']:
            run.note(f'Seed {seed}: {fault if summary is None else reason(summary)}')
    heads = 'seed | goals | true error at the goals mm: median / 95 % / max | fused error at the goals mm'
    more = 'fused error mm | clearance mm | collisions | path m | simulated s | wall s'
    table = run.table('Missions', heads, more)
    for summary in summaries:
        add_row(table, str(summary['seed']), [summary])
    if summaries:
        add_row(table, 'all', summaries)


def add_row(table: Any, name: str, summaries: list[Summary]) -> None:
    """Add the figures of some missions."""
    goals = [goal for summary in summaries for goal in summary['goals']]
    fused = [summary['poses']['pose_arbiter'] for summary in summaries]
    table.add(
        *(name, rate(sum(goal['good'] for goal in goals), 3 * len(summaries))),
        *(error([goal[key] for goal in goals], '.1f', 1e3) for key in ('true_error', 'fused_error')),
        error([pose['worst'] for pose in fused if pose['count']], '.1f', 1e3),
        error([summary['least_clearance'] for summary in summaries], '.0f', 1e3, (50, 5, 0), 'higher'),
        count(sum(summary['collisions'] for summary in summaries), better='lower'),
        error([summary['path_length'] for summary in summaries], '.1f', shown=(50,)),
        error([summary['seconds'] for summary in summaries], '.0f', shown=(50,)),
        measured(sum(summary['timing']['drive'] for summary in summaries) / len(summaries), '.0f'),
    )


if __name__ == '__main__':
    run_benchmark(
        main,
        seeds=Option(20, 0, 'how many'),
        first=Option(0, 0, 'the first one'),
        resume=Option(False, False, 'keep the figures in the folder'),
    )
