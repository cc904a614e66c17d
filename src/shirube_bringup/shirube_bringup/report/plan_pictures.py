"""Top views: all tracks over the room, and the planner's map over the true obstacles."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap

from scene_simulator.mission.layout import ROBOT_RADIUS, ROOM
from shirube_bringup.record import GridMap, MissionTraces
from shirube_bringup.report.picture_style import COLOURS, LABELS, TRUTH, draw_zones, picture
from shirube_bringup.report.trace_errors import align_all_poses, as_array

_OCCUPIED = 50
_MARGIN = 0.15


def draw_tracks(path: Path, traces: MissionTraces) -> None:
    """Write the figure of all tracks to a PNG file."""
    poses, truth = align_all_poses(traces), as_array(traces.truth)
    with picture(path, 11.0, 7.6) as figure:
        axes = figure.add_subplot()
        draw_zones(axes)
        _draw_room(axes, traces, filled=True)
        axes.plot(truth[:, 1], truth[:, 2], color=TRUTH, linewidth=4.0, alpha=0.35, label='true')
        for name in ('odometry', 'pose_arbiter'):
            style = '--' if name == 'odometry' else '-'
            axes.plot(*poses[name][:, 1:3].T, style, color=COLOURS[name], linewidth=1.2, label=LABELS[name])
        for name in ('vlc_beacon', 'floor_localizer', 'stereo_landmark'):
            localizer_poses = poses.get(name, np.empty((0, 4)))
            size = 7.0 if name == 'stereo_landmark' else 2.5
            axes.plot(
                *localizer_poses[:, 1:3].T,
                '.',
                color=COLOURS[name],
                markersize=size,
                label=f'{name}: {len(localizer_poses)} poses',
            )
        _draw_goals(axes, traces)
        _finish(axes, 'Tracks of the mission')


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
        _finish(
            axes,
            "The planner's last map: black occupied, white free, grey unknown; red: true obstacles",
        )


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
        axes.add_patch(
            plt.Rectangle((x0, y0), x1 - x0, y1 - y0, fill=filled, color=colour, linewidth=1.3, label=label)
        )
    x0, y0, _, x1, y1, _ = ROOM
    axes.add_patch(plt.Rectangle((x0, y0), x1 - x0, y1 - y0, fill=False, color=colour, linewidth=2.0))


def _draw_goals(axes: Axes, traces: MissionTraces) -> None:
    layout = traces.layout
    for number, pose in enumerate((layout.start, *layout.goals)):
        axes.add_patch(plt.Circle((pose.x, pose.y), ROBOT_RADIUS, fill=False, color='k', linewidth=1.0))
        axes.plot(
            [pose.x, pose.x + ROBOT_RADIUS * math.cos(pose.yaw)],
            [pose.y, pose.y + ROBOT_RADIUS * math.sin(pose.yaw)],
            color='k',
        )
        name = f'goal {number}' if number else 'start'
        axes.annotate(name, (pose.x, pose.y + 1.2 * ROBOT_RADIUS), ha='center', fontweight='bold')


def _finish(axes: Axes, title: str) -> None:
    x0, y0, _, x1, y1, _ = ROOM
    axes.set(
        aspect='equal',
        xlim=(x0 - _MARGIN, x1 + _MARGIN),
        ylim=(y0 - _MARGIN, y1 + _MARGIN),
        xlabel='x [m]',
        ylabel='y [m]',
        title=title,
    )
    axes.legend(loc='upper left', bbox_to_anchor=(1.01, 1.0), fontsize='small')
