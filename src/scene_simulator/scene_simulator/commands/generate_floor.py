"""``generate_floor``: lay a floor of random chips and write its dot map; by default the demo's floor."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from scene_simulator.demo_scene import DEMO_FLOOR_SEED
from scene_simulator.dot_floor import DARK_ON_LIGHT, generate_dot_floor
from scene_simulator.errors import SceneError
from scene_simulator.simulated_survey import SURVEY_ERROR, survey_floor, write_dot_map


def main() -> int:
    """Run the command and return its exit code."""
    arguments = _parser().parse_args()
    design = replace(DARK_ON_LIGHT, size=tuple(arguments.size), count=arguments.count)
    try:
        floor = generate_dot_floor(design, arguments.seed)
        dots = survey_floor(floor, arguments.survey_error, arguments.seed + 1)
        write_dot_map(dots, arguments.map)
    except SceneError as error:
        print(f'generate_floor: {error}', file=sys.stderr)
        return 1
    width, length = design.size
    print(f'{arguments.map}: {len(dots)} dots on {width} x {length} m')
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='generate_floor', description=__doc__)
    parser.add_argument('map', type=Path, help='CSV file to write: x,y,diameter in metres')
    parser.add_argument(
        '--size',
        type=float,
        nargs=2,
        metavar=('X', 'Y'),
        default=DARK_ON_LIGHT.size,
        help='extent of the floor [m] (default: %(default)s)',
    )
    parser.add_argument(
        '--count', type=int, default=DARK_ON_LIGHT.count, help='number of chips (default: %(default)s)'
    )
    parser.add_argument(
        '--seed', type=int, default=DEMO_FLOOR_SEED, help='seed of the floor (default: %(default)s)'
    )
    parser.add_argument(
        '--survey-error',
        type=float,
        default=SURVEY_ERROR,
        help='standard deviation of the map along each axis [m] (default: %(default)s)',
    )
    return parser


if __name__ == '__main__':
    sys.exit(main())
