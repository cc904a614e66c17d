"""Figures over time: errors, measurement status, speed and commands, timing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from shirube_bringup.record import FUSED_ERROR_MAX, MissionTraces
from shirube_bringup.report.picture_style import COLOURS, LABELS, TRUTH, mark_goals, picture, shade_zones
from shirube_bringup.report.trace_errors import align_all_poses, as_array, compute_speeds, pose_errors

_SOURCES = ('floor_localizer', 'vlc_beacon', 'stereo_landmark')
_STATUS_COLOURS = ('#dc2626', '#f59e0b', '#9333ea', '#0891b2', '#be185d', '#525252')
_USED = 'used'
_ERROR_MIN = 1e-2
"""Smaller errors are drawn at this value [mm]: the axis is logarithmic."""


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
            distance.plot(
                times,
                np.maximum(1e3 * position_error, _ERROR_MIN),
                color=colour,
                label=LABELS.get(name, name),
                **style,
            )
            heading.plot(times, np.degrees(yaw_error), color=colour, **style)
        distance.axhline(
            1e3 * FUSED_ERROR_MAX, color='k', linestyle='--', linewidth=0.9, label='limit at a goal (fused)'
        )
        distance.set(yscale='log', ylabel='position error [mm]', title='Errors against ground truth')
        heading.set(xlabel='simulated time [s]', ylabel='yaw error [deg]', ylim=(-6.0, 6.0))
        for axes in (distance, heading):
            _finish(axes, traces)
        distance.legend(loc='upper left', bbox_to_anchor=(1.01, 1.0), fontsize='small')


def draw_measurement_status(path: Path, traces: MissionTraces) -> None:
    """Write the figure of the measurement status of each source's poses per second to a PNG file."""
    statuses = sorted({count.verdict for count in traces.trust} - {_USED})
    colours = dict(zip(statuses, _STATUS_COLOURS * (1 + len(statuses) // len(_STATUS_COLOURS)), strict=False))
    with picture(path, 13.0, 7.0) as figure:
        rows: Sequence[Axes] = figure.subplots(len(_SOURCES), 1, sharex=True)
        for axes, source in zip(rows, _SOURCES, strict=True):
            _draw_bars(axes, traces, source, {_USED: '#15803d', **colours})
            axes.set(ylabel=f'{source}\nposes per second', ylim=(0.0, None))
            _finish(axes, traces)
        rows[0].set_title(
            'Measurement status of the poses of each localizer in pose_arbiter; no bar: no poses'
        )
        rows[-1].set_xlabel('simulated time [s]')
        handles = {
            label: handle
            for axes in rows
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        if handles:
            figure.legend(handles.values(), handles.keys(), loc='outside right upper', fontsize='small')


def _draw_bars(axes: Axes, traces: MissionTraces, source: str, colours: dict[str, str]) -> None:
    """Draw one stacked bar per simulated second; the arbiter reports in wall time, so more often."""
    seconds = np.arange(0.0, np.ceil(traces.truth[-1][0]) + 1.0)
    floor = np.zeros(len(seconds) - 1)
    for verdict, colour in colours.items():
        counts = [(c.time, c.count) for c in traces.trust if (c.source, c.verdict) == (source, verdict)]
        if counts:
            times, totals = np.array(counts).T
            totals = np.concatenate([[0.0], totals])
            rate = np.diff(totals[np.searchsorted(times, seconds, side='right')])
            axes.bar(seconds[:-1], rate, 1.0, floor, align='edge', color=colour, label=verdict)
            floor += rate


def draw_speed(path: Path, traces: MissionTraces, commands: Sequence[tuple[float, str]]) -> None:
    """Write the figure of the robot's speed and the lamps' commands to a PNG file.

    Args:
        path: path of the PNG file.
        traces: time series of the mission.
        commands: time [s] and text of the commands of lamps.
    """
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
            _finish(axes, traces)
        speed.legend(loc='upper left', bbox_to_anchor=(1.01, 1.0), fontsize='small')


def draw_timing(path: Path, traces: MissionTraces) -> None:
    """Write the figure of the timing to a PNG file."""
    pace = np.array(traces.pace, dtype=np.float64).reshape(-1, 2)
    with picture(path, 13.0, 4.2) as figure:
        over_time, sums = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
        if len(pace) > 1:
            over_time.step(pace[1:, 0], np.diff(pace[:, 1]) / np.diff(pace[:, 0]), where='pre', color=TRUTH)
        over_time.axhline(1.0, color='k', linestyle='--', linewidth=0.8, label='real time')
        over_time.set(
            xlabel='simulated time [s]', ylabel='wall time per simulated second [s]', ylim=(0.0, None)
        )
        over_time.legend(fontsize='small')
        over_time.grid(alpha=0.3)
        names = sorted(traces.cpu, key=lambda name: traces.cpu[name])
        bars = sums.barh(
            names, [traces.cpu[name] for name in names], color=[COLOURS.get(n, '#64748b') for n in names]
        )
        sums.bar_label(bars, fmt=' %.0f s')
        sums.margins(x=0.15)
        sums.set(xlabel='CPU time during the drive [s]')


def _finish(axes: Axes, traces: MissionTraces) -> None:
    shade_zones(axes, as_array(traces.truth))
    mark_goals(axes, [end for _, end in traces.legs])
    axes.grid(alpha=0.3)
    axes.set_xlim(0.0, max(traces.truth[-1][0], 1.0))
