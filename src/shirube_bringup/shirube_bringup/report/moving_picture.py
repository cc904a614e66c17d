"""The moving picture of a mission: the robot, people, tracks and the status of each source."""

from collections.abc import Iterable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from scene_simulator.mission.layout import ROBOT_RADIUS, ZONES
from shirube_bringup.record import MissionTraces, as_array
from shirube_bringup.report.figures import COLOURS, PEOPLE, TRUTH, ZONE_COLOURS, ZONE_LABELS, draw_background
from shirube_bringup.report.replay import SOURCES, main_status
from shirube_bringup.report.trace_errors import align_all_poses

_RATE, _IMAGES, _LAST = 10, 130, 15  # images per second, images of the drive, and images at its end
_PERSON_RADIUS, _TRAIL = 0.25, 8.0  # radius of a person [m], and for how long a source's pose is shown [simulated s]


class _Drive:
    """What moves over axes that show the room."""

    def __init__(self, axes: Axes, traces: MissionTraces) -> None:
        self._traces, self._truth = traces, as_array(traces.truth)
        self._poses, self._status = align_all_poses(traces), main_status(traces)
        styles = {'truth': (TRUTH, 5.0, 0.35), 'pose_arbiter': (COLOURS['pose_arbiter'], 1.4, 1.0)}
        self._lines = {
            name: axes.plot([], [], color=colour, linewidth=width, alpha=alpha)[0]
            for name, (colour, width, alpha) in styles.items()
        }
        self._dots = {name: axes.plot([], [], '.', color=COLOURS[name], markersize=7.0)[0] for name in SOURCES}
        self._people = [_add_circle(axes, _PERSON_RADIUS, PEOPLE) for _ in (traces.people[0] if traces.people else ())]
        self._robot, (self._heading,) = _add_circle(axes, ROBOT_RADIUS, TRUTH), axes.plot([], [], color=TRUTH)
        self._title = axes.set_title('', loc='left', fontsize='medium')
        places = ((0.0, -0.035), (0.36, -0.035), (0.69, -0.035))
        self._words = {
            name: axes.text(*place, '', color=COLOURS[name], transform=axes.transAxes, va='top', fontsize='medium')
            for name, place in zip(SOURCES, places, strict=True)
        }

    def show(self, time: float) -> Iterable[Artist]:
        """Show a time [s]."""
        step = int(np.searchsorted(self._truth[:, 0], time, side='right')) - 1
        _, x, y, yaw = self._truth[step]
        for name, line in self._lines.items():
            poses = self._truth if name == 'truth' else self._poses[name]
            line.set_data(*poses[poses[:, 0] <= time, 1:3].T)
        for name, dots in self._dots.items():
            poses = self._poses.get(name, np.empty((0, 4)))
            dots.set_data(*poses[(poses[:, 0] <= time) & (poses[:, 0] > time - _TRAIL), 1:3].T)
            self._words[name].set_text(f'● {name}:\n    {self._status[name][int(time)] or "no poses"}')
        for circle, place in zip(self._people, self._traces.people[step] if self._people else (), strict=True):
            circle.set_center(place)
        self._robot.set_center((x, y))
        self._heading.set_data([x, x + ROBOT_RADIUS * np.cos(yaw)], [y, y + ROBOT_RADIUS * np.sin(yaw)])
        reached = sum(end <= time for _, end in self._traces.legs)
        goals = f'{reached} of {len(self._traces.layout.goals)} goals reached'
        self._title.set_text(f'{time:.0f} s, {goals}.   Blue: true track, red: fused pose, pink: people')
        return ()


def _add_circle(axes: Axes, radius: float, colour: str) -> plt.Circle:
    circle = plt.Circle((-9.0, -9.0), radius, facecolor=f'{colour}59', edgecolor=colour, linewidth=1.8)
    axes.add_patch(circle)
    return circle


def write_moving_picture(path: Path, traces: MissionTraces) -> None:
    """Write the mission as an animation of 14.5 s, 800 pixels wide, to a file whose name ends with .gif or .webp."""
    figure = plt.figure(figsize=(8.0, 6.6))
    axes = figure.add_axes((0.01, 0.085, 0.98, 0.87))
    draw_background(axes, traces)
    axes.axis('off')
    for name, zone in ZONES.items():
        words = {'color': ZONE_COLOURS[name], 'ha': 'center', 'va': 'bottom'}
        axes.text((zone.low[0] + zone.high[0]) / 2.0, zone.low[1] + 0.05, ZONE_LABELS[name], **words)
    drive, end = _Drive(axes, traces), traces.truth[-1][0]
    times = np.append(np.linspace(traces.truth[0][0], end, _IMAGES), np.full(_LAST, end))
    unfinished = path.with_stem(f'.{path.stem}.part')
    FuncAnimation(figure, drive.show, times.tolist()).save(unfinished, PillowWriter(_RATE), dpi=100)
    unfinished.replace(path)
    plt.close(figure)
