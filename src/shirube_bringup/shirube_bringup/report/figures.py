"""The figures of the report: top views of the room, and errors, measurement status, speed and timing over time."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from scene_simulator.mission.layout import ROBOT_RADIUS, ROOM, ZONES
from shirube_bringup.record import FUSED_ERROR_MAX, Array, GridMap, MissionTraces, as_array, pose_errors
from shirube_bringup.report.replay import SOURCES
from shirube_bringup.report.trace_errors import align_all_poses, compute_speeds, status_rates, zone_spans
from shirube_core.files import atomic_write

COLOURS = {
    'floor_localizer': '#15803d',
    'stereo_landmark': '#7c3aed',
    'vlc_beacon': '#d97706',
    'pose_arbiter': '#c2410c',
    'odometry': '#64748b',
}
LABELS = {'pose_arbiter': 'fused (pose_arbiter)', 'odometry': 'odometry alone'}
TRUTH, PEOPLE = '#1d4ed8', '#be185d'
ZONE_COLOURS = {'carpet': '#a16207', 'dark': '#1e293b', 'covered': '#0e7490'}
ZONE_LABELS = {'carpet': 'carpet: no dots', 'dark': 'lamps off', 'covered': 'landmarks covered'}
_OCCUPIED = 50
_MARGIN = 0.15
_STATUS_COLOURS = ('#dc2626', '#f59e0b', '#9333ea', '#0891b2', '#be185d', '#525252')
_USED = 'used'
_ERROR_MIN = 1e-2  # smaller errors are drawn at this value [mm]: the axis is logarithmic


@contextmanager
def picture(path: Path, width: float, height: float) -> Iterator[Figure]:
    """Provide a figure of a size [inch]; write it to a PNG file at the end."""
    figure = plt.figure(figsize=(width, height), layout='constrained')
    try:
        yield figure
        with atomic_write(path) as file:
            figure.savefig(file, format='png', dpi=100, bbox_inches='tight')
    finally:
        plt.close(figure)


def _legend(axes: Axes) -> None:
    axes.legend(loc='upper left', bbox_to_anchor=(1.01, 1.0), fontsize='small')


def _add_box(axes: Axes, low: tuple[float, float], high: tuple[float, float], **style: Any) -> None:
    axes.add_patch(plt.Rectangle(low, high[0] - low[0], high[1] - low[1], **style))


def draw_tracks(path: Path, traces: MissionTraces) -> None:
    """Write the figure of all tracks to a PNG file."""
    poses, truth = align_all_poses(traces), as_array(traces.truth)
    with picture(path, 11.0, 7.6) as figure:
        axes = figure.add_subplot()
        draw_background(axes, traces)
        axes.plot(truth[:, 1], truth[:, 2], color=TRUTH, linewidth=4.0, alpha=0.35, label='true')
        for name in ('odometry', 'pose_arbiter'):
            line = '--' if name == 'odometry' else '-'
            axes.plot(*poses[name][:, 1:3].T, line, color=COLOURS[name], linewidth=1.2, label=LABELS[name])
        for name in ('vlc_beacon', 'floor_localizer', 'stereo_landmark'):
            localizer_poses = poses.get(name, np.empty((0, 4)))
            size = 7.0 if name == 'stereo_landmark' else 2.5
            label = f'{name}: {len(localizer_poses)} poses'
            axes.plot(*localizer_poses[:, 1:3].T, '.', color=COLOURS[name], markersize=size, label=label)
        for number in range(len(traces.people[0]) if traces.people else 0):
            way = np.array([places[number] for places in traces.people])
            axes.plot(*way.T, ':', color=PEOPLE, linewidth=1.5, label='people' if number == 0 else None)
        _finish_plan(axes, 'Tracks of the mission')


def draw_background(axes: Axes, traces: MissionTraces) -> None:
    """Draw zones, room, obstacles and goals, seen from above."""
    for name, zone in ZONES.items():
        style: dict[str, Any] = {'color': ZONE_COLOURS[name], 'alpha': 0.15, 'label': ZONE_LABELS[name]}
        _add_box(axes, zone.low, zone.high, **style)
    _draw_room(axes, traces, filled=True)
    _draw_goals(axes, traces)


def draw_map(path: Path, traces: MissionTraces) -> None:
    """Write the figure of the planner's last map to a PNG file."""
    truth = as_array(traces.truth)
    with picture(path, 11.0, 7.0) as figure:
        axes = figure.add_subplot()
        if traces.map is None:
            axes.text(4.0, 3.0, 'the planner published no map', ha='center')
        else:
            _draw_grid(axes, traces.map)
        _draw_room(axes, traces, filled=False)
        axes.plot(truth[:, 1], truth[:, 2], color=TRUTH, linewidth=1.5, label='true track')
        _draw_goals(axes, traces)
        _finish_plan(axes, "The planner's last map: black occupied, white free, grey unknown; red: true obstacles")


def _draw_grid(axes: Axes, grid: GridMap) -> None:
    cells = np.array(grid.cells).reshape(grid.shape)
    kinds = np.where(cells < 0, 0, np.where(cells >= _OCCUPIED, 2, 1))
    (left, low), (rows, columns) = grid.corner, grid.shape
    extent = (left, left + columns * grid.resolution, low, low + rows * grid.resolution)
    colours = ListedColormap(['#c9ced6', '#ffffff', '#111827'])
    axes.imshow(kinds, cmap=colours, vmin=0, vmax=2, origin='lower', extent=extent, interpolation='nearest')


def _draw_room(axes: Axes, traces: MissionTraces, *, filled: bool) -> None:
    colour = '#94a3b8' if filled else '#dc2626'
    for number, (x0, y0, _, x1, y1, _) in enumerate(traces.boxes):
        label = ('obstacles' if filled else 'true obstacles') if number == 0 else None
        _add_box(axes, (x0, y0), (x1, y1), fill=filled, color=colour, linewidth=1.3, label=label)
    _add_box(axes, ROOM[:2], ROOM[3:5], fill=False, color=colour, linewidth=2.0)
    x0, y0, _, x1, y1, _ = ROOM
    axes.set(aspect='equal', xlim=(x0 - _MARGIN, x1 + _MARGIN), ylim=(y0 - _MARGIN, y1 + _MARGIN))


def _draw_goals(axes: Axes, traces: MissionTraces) -> None:
    layout = traces.layout
    for number, pose in enumerate((layout.start, *layout.goals)):
        axes.add_patch(plt.Circle((pose.x, pose.y), ROBOT_RADIUS, fill=False, color='k', linewidth=1.0))
        ahead = pose.x + ROBOT_RADIUS * math.cos(pose.yaw), pose.y + ROBOT_RADIUS * math.sin(pose.yaw)
        axes.plot([pose.x, ahead[0]], [pose.y, ahead[1]], color='k')
        name = f'goal {number}' if number else 'start'
        axes.annotate(name, (pose.x, pose.y + 1.2 * ROBOT_RADIUS), ha='center', fontweight='bold')


def _finish_plan(axes: Axes, title: str) -> None:
    axes.set(xlabel='x [m]', ylabel='y [m]', title=title)
    _legend(axes)


def draw_errors(path: Path, traces: MissionTraces) -> None:
    """Write the figure of the errors over time to a PNG file."""
    truth, poses = as_array(traces.truth), align_all_poses(traces)
    with picture(path, 13.0, 7.5) as figure:
        distance, heading = figure.subplots(2, 1, sharex=True, height_ratios=(1.7, 1.0))
        for name, colour in COLOURS.items():
            if not len(poses.get(name, ())):
                continue
            times, position_error, yaw_error = pose_errors(poses[name], truth)
            is_line = name in LABELS
            style = {'linewidth': 1.3} if is_line else {'marker': '.', 'linestyle': '', 'markersize': 3.0}
            errors = np.maximum(1e3 * position_error, _ERROR_MIN)
            distance.plot(times, errors, color=colour, label=LABELS.get(name, name), **style)
            heading.plot(times, np.degrees(yaw_error), color=colour, **style)
        distance.axhline(
            1e3 * FUSED_ERROR_MAX, color='k', linestyle='--', linewidth=0.9, label='limit at a goal (fused)'
        )
        distance.set(yscale='log', ylabel='position error [mm]', title='Errors against ground truth')
        heading.set(xlabel='simulated time [s]', ylabel='yaw error [deg]', ylim=(-6.0, 6.0))
        for axes in (distance, heading):
            _finish_times(axes, traces)
        _legend(distance)


def draw_measurement_status(path: Path, traces: MissionTraces) -> None:
    """Write the figure of the measurement status of each source's poses per second to a PNG file."""
    statuses = sorted({count.verdict for count in traces.trust} - {_USED})
    colours = dict(zip(statuses, _STATUS_COLOURS * (1 + len(statuses) // len(_STATUS_COLOURS)), strict=False))
    with picture(path, 13.0, 7.0) as figure:
        rows: Sequence[Axes] = figure.subplots(len(SOURCES), 1, sharex=True)
        for axes, source in zip(rows, SOURCES, strict=True):
            _draw_bars(axes, traces, source, {_USED: '#15803d', **colours})
            axes.set(ylabel=f'{source}\nposes per second', ylim=(0.0, None))
            _finish_times(axes, traces)
        rows[0].set_title('Measurement status of the poses of each localizer in pose_arbiter; no bar: no poses')
        rows[-1].set_xlabel('simulated time [s]')
        entries = (axes.get_legend_handles_labels() for axes in rows)
        handles = {label: handle for entry in entries for handle, label in zip(*entry, strict=True)}
        if handles:
            figure.legend(handles.values(), handles.keys(), loc='outside right upper', fontsize='small')


def _draw_bars(axes: Axes, traces: MissionTraces, source: str, colours: dict[str, str]) -> None:
    """Draw one stacked bar per simulated second."""
    rates = status_rates(traces, source)
    floor: Array | float = 0.0
    for status in [name for name in colours if name in rates]:
        rate, style = rates[status], {'color': colours[status], 'label': status}
        axes.bar(np.arange(len(rate)), rate, 1.0, floor, align='edge', **style)
        floor += rate


def draw_speed(path: Path, traces: MissionTraces, commands: Sequence[tuple[float, str]]) -> None:
    """Write the figure of the robot's speed and the lamps' commands, time [s] and text of each, to a PNG file."""
    with picture(path, 13.0, 5.5) as figure:
        speed, clearance = figure.subplots(2, 1, sharex=True)
        speed.plot(*compute_speeds(as_array(traces.truth)), color=TRUTH, linewidth=1.2, label='true speed')
        for time, command in commands:
            speed.axvline(time, color='#d97706', linewidth=1.5)
            speed.annotate(
                f' {command}',
                (time, 0.86),
                xycoords=('data', 'axes fraction'),
                annotation_clip=True,  # an annotation outside the axes would shrink them
                color='#b45309',
                fontweight='bold',
            )
        speed.set(
            ylabel='true speed [m/s]',
            ylim=(0.0, 0.5),
            title='Speed, commands of the lamps (orange), and clearance of the robot',
        )
        clearance.plot(as_array(traces.truth)[:, 0], traces.clearance, color='#0f766e', linewidth=1.2)
        clearance.axhline(0.0, color='#dc2626', linewidth=1.2)
        clearance.set(xlabel='simulated time [s]', ylabel='clearance [m]')
        for axes in (speed, clearance):
            _finish_times(axes, traces)
        _legend(speed)


def draw_timing(path: Path, traces: MissionTraces) -> None:
    """Write the figure of the timing to a PNG file."""
    pace = np.array(traces.pace, dtype=np.float64).reshape(-1, 2)
    with picture(path, 13.0, 4.2) as figure:
        over_time, sums = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
        if len(pace) > 1:
            over_time.step(pace[1:, 0], np.diff(pace[:, 1]) / np.diff(pace[:, 0]), where='pre', color=TRUTH)
        over_time.axhline(1.0, color='k', linestyle='--', linewidth=0.8, label='real time')
        over_time.set(xlabel='simulated time [s]', ylabel='wall time per simulated second [s]', ylim=(0.0, None))
        over_time.legend(fontsize='small')
        over_time.grid(alpha=0.3)
        names = sorted(traces.cpu, key=lambda name: traces.cpu[name])
        bars = sums.barh(names, [traces.cpu[name] for name in names], color=[COLOURS.get(n, '#64748b') for n in names])
        sums.bar_label(bars, fmt=' %.0f s')
        sums.margins(x=0.15)
        sums.set(xlabel='CPU time during the drive [s]')


def _finish_times(axes: Axes, traces: MissionTraces) -> None:
    """Shade the times in a zone and mark the end of each goal."""
    for name, spans in zone_spans(as_array(traces.truth)).items():
        for number, (start, end) in enumerate(spans):
            label = ZONE_LABELS[name] if number == 0 else None
            axes.axvspan(start, end, color=ZONE_COLOURS[name], alpha=0.15, linewidth=0, label=label)
    style: dict[str, Any] = {'xycoords': ('data', 'axes fraction'), 'ha': 'right', 'va': 'top', 'fontsize': 'small'}
    for number, (_, end) in enumerate(traces.legs, start=1):
        axes.axvline(end, color='k', linewidth=0.8, linestyle=':')
        axes.annotate(f'goal {number} ', (end, 1.0), **style)
    axes.grid(alpha=0.3)
    axes.set_xlim(0.0, max(traces.truth[-1][0], 1.0))
