"""``room``: drive a simulated robot through a room to three goals; each node runs in its own process."""

import argparse
import json
import os
import signal
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from scene_simulator.errors import SceneError
from shirube_bags.errors import ShirubeBagsError
from shirube_bringup.building import write_building
from shirube_bringup.nodes import PLANNERS, MissionError
from shirube_bringup.report.page import write_report
from shirube_bringup.run import run_mission
from shirube_core.command import run_command
from shirube_core.files import write_text
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0 after a successful mission, else 1."""
    options = _parser().parse_args(arguments)
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C: otherwise the render worker stays
    errors = (MissionError, SceneError, ShirubeBagsError, StereoLandmarkError)
    try:
        return run_command('room', lambda: _drive(options), errors)
    except KeyboardInterrupt:
        print('room: interrupted; the nodes have ended', file=sys.stderr)
        return 1


def _drive(options: argparse.Namespace) -> int:
    """Run the mission and write its files; return 0 if it was successful, else 1."""
    check_bag_path(options.record)
    options.folder.mkdir(parents=True, exist_ok=True)
    files = write_building((options.building or options.folder / 'building').absolute())
    folder, log = options.folder.absolute(), partial(print, flush=True)
    chosen = {name: getattr(options, name) for name in ('launched', 'planner', 'people', 'domain')}
    summary, traces = run_mission(
        options.seed, files, folder, log, options.record, is_kidnapped=options.kidnap, **chosen
    )
    write_text(options.folder / 'summary.json', json.dumps(summary, indent=2) + '\n')
    lines = ''.join(f'{t:.2f},{x:.4f},{y:.4f},{yaw:.4f}\n' for t, x, y, yaw in traces.truth)
    write_text(options.folder / 'track.csv', f't,x,y,yaw\n{lines}')
    write_text(options.folder / 'traces.json', traces.as_json())
    print(f'Report: {write_report(options.folder, summary, traces)}')
    print(f'{"success" if summary["success"] else "FAILURE"}: {summary["ended"]}')
    return 0 if summary['success'] else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='room', description=__doc__)
    parser.add_argument(
        'folder', type=Path, help='folder for report.html, summary.json, track.csv, traces.json and logs'
    )
    parser.add_argument('--seed', type=int, default=0, help='seed of room, robot and noise (default: %(default)s)')
    parser.add_argument(
        '--building', type=Path, help='folder of map, lamps and taught places (default: FOLDER/building)'
    )
    parser.add_argument('--record', type=Path, metavar='BAG', help='record the mission to this bag (a new folder)')
    about = "shortest routes, or the paper's map and reward rule (default: %(default)s)"
    parser.add_argument('--planner', choices=sorted(PLANNERS), default='default', help=about)
    parser.add_argument('--kidnap', action='store_true', help='carry the robot away at the first goal')
    parser.add_argument('--people', type=int, default=2, help='people who walk in the room (default: %(default)s)')
    parser.add_argument('--domain', type=int, help='ROS domain of the nodes (default: a free one)')
    parser.add_argument(
        '--launched', action='store_true', help='do not start the nodes; wait for nodes that ROS launch starts'
    )
    return parser


def check_bag_path(bag: Path | None) -> None:
    """Raise a MissionError before the mission if its bag exists."""
    if bag is not None and bag.exists():
        raise MissionError(f'{bag}: exists already; remove it or choose another name for the bag')


if __name__ == '__main__':
    sys.exit(main())
