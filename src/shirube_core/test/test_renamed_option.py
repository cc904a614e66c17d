"""Former names of options."""

import argparse

import pytest

from shirube_core.settings import reject_former_option


def make_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='tool')
    parser.add_argument('--submap-length', type=float, default=2.0)
    reject_former_option(parser, 'piece_length', 'submap_length')
    return parser


def test_a_former_name_ends_with_the_new_one(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        make_parser().parse_args(['--piece-length', '3'])
    assert 'tool: error: --piece-length is now called --submap-length' in capsys.readouterr().err


def test_the_new_name_works_and_the_help_shows_no_other() -> None:
    assert make_parser().parse_args([]).submap_length == 2.0
    assert make_parser().parse_args(['--submap-length', '3']).submap_length == 3.0
    assert 'piece' not in make_parser().format_help()
