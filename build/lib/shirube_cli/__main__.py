"""Lets ``python -m shirube_cli`` do what the command ``shirube`` does."""

import sys

from shirube_cli.main import main

if __name__ == '__main__':
    sys.exit(main())
