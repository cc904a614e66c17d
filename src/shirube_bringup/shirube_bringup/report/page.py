"""The report of a mission: a page with result, replay, figures, and tables of goals, accuracy, commands and timing."""

import html
import json
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from shirube_bringup.record import (
    FUSED_ERROR_MAX,
    TRUE_ERROR_MAX,
    Array,
    MissionTraces,
    as_array,
    count_collisions,
    pose_errors,
)
from shirube_bringup.report.figures import (
    LABELS,
    draw_errors,
    draw_map,
    draw_measurement_status,
    draw_speed,
    draw_timing,
    draw_tracks,
)
from shirube_bringup.report.replay import replay_data
from shirube_bringup.report.trace_errors import align_all_poses, zone_spans
from shirube_core.files import write_text

PICTURES = {
    'tracks.png': 'Tracks',
    'errors.png': 'Errors over time',
    'trust.png': 'Used and rejected poses over time',
    'map.png': 'Map of the robot',
    'speed.png': 'Speed and commands of the lamps',
    'timing.png': 'Timing',
}
"""Files and titles of the figures."""

_WHAT = (
    'The nodes drove a simulated robot to three goals, among people and obstacles that are not on its map; floor dots, '
    'lamps and landmarks were each missing in one zone. Every pose is compared with the true pose at its stamp.'
)
PAGE = 'report.html'


def page(summary: Mapping[str, Any], traces: MissionTraces) -> str:
    """Return the HTML page, from the data of `summary.json`."""
    tables = [
        _section('Goals', goal_table(summary, traces)),
        _section('Poses', _accuracy_table(traces)),
        _section('Zones', _zone_table(summary, traces)),
        _section('Commands of the lamps', _command_table(summary)),
        _section('Cameras', _camera_table(summary, traces)),
        _timing_sentence(summary),
    ]
    pictures = [
        f'<figure><figcaption>{title}</figcaption><img src="{name}" alt="{title}"></figure>'
        for name, title in PICTURES.items()
    ]
    static = files('shirube_bringup.report') / 'static'
    return Template((static / PAGE).read_text()).substitute(
        seed=summary['seed'],
        verdict='passed' if summary['success'] else 'failed',
        sentence=html.escape(result_sentence(summary)),
        what=_WHAT,
        tables='\n'.join(tables),
        pictures='\n'.join(pictures),
        style=(static / 'report.css').read_text(),
        script=(static / 'replay.js').read_text(),
        replay=json.dumps(replay_data(traces), separators=(',', ':')).replace('<', '\\u003c'),
    )


def result_sentence(summary: Mapping[str, Any]) -> str:
    """Return whether the mission succeeded, with the reasons if not."""
    if summary['success']:
        return 'Success: every goal was reached within the limits, without a collision.'
    bad = [str(k) for k, goal in enumerate(summary['goals'], start=1) if not goal['good']]
    reasons = [summary['ended']] if summary['ended'] else []
    if bad:
        reasons.append(f'outside the limits: goal {", ".join(bad)}')
    if summary['collisions']:
        reasons.append(f'{summary["collisions"]} collisions')
    return f'Failure: {"; ".join(reasons)}.'


def goal_table(summary: Mapping[str, Any], traces: MissionTraces) -> str:
    """Return the table of all goals, including those that were not started."""
    rows = []
    for number in range(len(traces.layout.goals)):
        if number >= len(summary['goals']):
            rows.append([f'goal {number + 1}', 'not reached', *['–'] * 6, 'FAIL'])
            continue
        goal = summary['goals'][number]
        clearance = _clearance_during(traces, traces.legs[number])
        rows.append(
            [
                f'goal {number + 1}',
                'reached' if goal['reached'] else 'not reached',
                f'{goal["seconds"]:.1f}',
                f'{1e3 * goal["true_error"]:.1f}',
                f'{1e3 * goal["fused_error"]:.1f}',
                f'{57.2958 * goal["yaw_error"]:.1f}',
                f'{100.0 * min(clearance):.1f}' if clearance else '–',
                str(count_collisions(clearance)),
                'pass' if goal['good'] and not count_collisions(clearance) else 'FAIL',
            ]
        )
    header = (
        'goal',
        'planner status',
        'time [s]',
        f'true pose error [mm], limit {1e3 * TRUE_ERROR_MAX:.0f}',
        f'fused pose error [mm], limit {1e3 * FUSED_ERROR_MAX:.0f}',
        'yaw error [deg]',
        'smallest clearance [cm]',
        'collisions, limit 0',
        'result',
    )
    return _table(header, rows)


def _clearance_during(traces: MissionTraces, leg: tuple[float, float]) -> list[float]:
    start, end = leg
    moments = zip(traces.truth, traces.clearance, strict=True)
    return [clearance for pose, clearance in moments if start < pose[0] <= end]


def _accuracy_table(traces: MissionTraces) -> str:
    truth, rows = as_array(traces.truth), []
    for name, poses in align_all_poses(traces).items():
        _, error, _ = pose_errors(poses, truth)
        if len(error):
            numbers = (_median(error), (error**2).mean() ** 0.5, error.max())
            rows.append([LABELS.get(name, name), str(len(error)), *(f'{1e3 * n:.1f}' for n in numbers)])
        else:
            rows.append([LABELS.get(name, name), '0', '–', '–', '–'])
    return _table(('source', 'poses', 'median error [mm]', 'rms [mm]', 'largest [mm]'), rows)


def _median(values: Array) -> float:
    return float(sorted(values.tolist())[len(values) // 2])


def _zone_table(summary: Mapping[str, Any], traces: MissionTraces) -> str:
    names = list(traces.poses)
    names = [name for name in names if name not in LABELS]
    spans, rows = zone_spans(as_array(traces.truth)), []
    for zone, inside in summary['zones'].items():
        when = ', '.join(f'{start:.0f}–{end:.0f}' for start, end in spans[zone])
        counts = [str(inside['poses'].get(name, 0)) for name in names]
        rows.append([zone, when or 'never', *counts, f'{1e3 * inside["worst_fused_error"]:.1f}'])
    header = ('zone', 'when [s]', *(f'poses of {name}' for name in names), 'largest fused error [mm]')
    return _table(header, rows)


def _command_table(summary: Mapping[str, Any]) -> str:
    rows = [[command['order'], f'{command["time"]:.1f}'] for command in summary['orders']]
    return _table(('command', 'received at [s]'), rows) if rows else '<p>No command was received.</p>'


def _camera_table(summary: Mapping[str, Any], traces: MissionTraces) -> str:
    drive = summary['timing']['drive'] / max(summary['seconds'], 1e-3)
    rows = [
        [name, f'{wanted:g}', f'{shown:.1f}', f'{shown / drive:.1f}'] for name, (wanted, shown) in traces.rates.items()
    ]
    header = ('camera', 'nominal [1/s]', 'achieved per simulated second', 'achieved per second of wall time')
    return _table(header, rows)


def _timing_sentence(summary: Mapping[str, Any]) -> str:
    timing, seconds = summary['timing'], summary['seconds']
    return (
        f'<p>{seconds:.1f} simulated seconds and {summary["path_length"]:.1f} m of path took {timing["drive"]:.0f} s; '
        f'the start took {timing["start"]:.0f} s, in total {timing["whole"]:.0f} s.</p>'
    )


def _section(title: str, table: str) -> str:
    return f'<h2>{title}</h2>\n{table}'


def _table(header: Iterable[str], rows: Iterable[Sequence[str]]) -> str:
    """Return an HTML table; cells with FAIL or pass are coloured."""
    lines = [''.join(f'<th>{html.escape(name)}</th>' for name in header)]
    lines += [''.join(f'<td{_css_class(cell)}>{html.escape(cell)}</td>' for cell in row) for row in rows]
    return '<div class="table"><table>\n' + '\n'.join(f'<tr>{line}</tr>' for line in lines) + '\n</table></div>'


def _css_class(cell: str) -> str:
    return {'FAIL': ' class="failed"', 'pass': ' class="passed"'}.get(cell, '')


def write_report(folder: Path, summary: Mapping[str, Any], traces: MissionTraces) -> Path:
    """Write page and figures to a folder, from the data of `summary.json`, and return the path of the page."""
    draw_tracks(folder / 'tracks.png', traces)
    draw_errors(folder / 'errors.png', traces)
    draw_measurement_status(folder / 'trust.png', traces)
    draw_map(folder / 'map.png', traces)
    draw_speed(folder / 'speed.png', traces, [(command['time'], command['order']) for command in summary['orders']])
    draw_timing(folder / 'timing.png', traces)
    write_text(folder / PAGE, page(summary, traces))
    return folder / PAGE
