"""``renew_counters``: reset the counter file of a robot, for a new key or after the file was lost."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from shirube_core.command import run_command
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.authorization_files import CounterFile


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when the floor is out of range or the file cannot be written."""
    parser = argparse.ArgumentParser(
        prog='renew_counters',
        description='Reset a counter file. Commands with counters below the floor are rejected from then on. With a '
        'new key the floor may be 0; with the old key it must be above all counters ever used.',
    )
    parser.add_argument('counter_file', type=Path, help='file to write; an existing file is replaced')
    parser.add_argument('--floor', type=int, required=True, help='lowest accepted counter; 0 with a new key')
    options = parser.parse_args(arguments)

    def reset() -> None:
        CounterFile(options.counter_file).reset(options.floor)
        print(f'{options.counter_file}: reset to {options.floor}; restart the node, which reads it at startup')

    return run_command('renew_counters', reset, (VlcBeaconError,))


if __name__ == '__main__':
    sys.exit(main())
