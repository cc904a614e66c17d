"""``make_key``: create a secret key for commands, to be copied to the robot and to the host that encodes them."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from shirube_core.command import run_command
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.authorization_files import make_key_file


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when the file exists or cannot be written."""
    parser = argparse.ArgumentParser(
        prog='make_key', description='Create a secret key for commands in a file that only its owner can read.'
    )
    parser.add_argument('key_file', type=Path, help='file to write; it must not exist')
    path = parser.parse_args(arguments).key_file

    def make_key() -> None:
        make_key_file(path)
        print(f'{path}: new key created; copy it to the robot and run there: renew_counters COUNTER_FILE --floor 0')

    return run_command('make_key', make_key, (VlcBeaconError,))


if __name__ == '__main__':
    sys.exit(main())
