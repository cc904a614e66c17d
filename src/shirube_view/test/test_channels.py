"""Messages as the page gets them."""

import base64
import json
import math
import zlib

import numpy as np
import pytest

from shirube_bags.bag_reader import jazzy_types
from shirube_view.board import Board, Seen
from shirube_view.channels import CHANNELS, Channel, Grid, plain

TYPES = jazzy_types().types
BY_NAME = {channel.name: channel for channel in CHANNELS}


def message(name, /, **fields):
    return TYPES[name](**fields)


def applied(picture, sent):
    """Return the grid of a page after it took a JSON object."""
    if not sent['patch']:
        picture = np.full(sent['size'], -1, np.int8)
    (row, column), (height, width) = sent['corner'], sent['shape']
    cells = np.frombuffer(zlib.decompress(base64.b64decode(sent['cells'])), np.int8).reshape(height, width)
    picture[row : row + height, column : column + width] = cells
    return picture


def test_a_page_that_takes_all_changes_has_the_same_grid():
    rng, before, picture = np.random.default_rng(1), None, None
    cells = np.full((20, 30), -1, np.int8)
    for number in range(60):
        if number % 20 == 19:
            cells = np.pad(cells, ((0, 3), (2, 0)), constant_values=-1)  # the map grows
        else:
            row, column = rng.integers(0, cells.shape)
            cells = cells.copy()
            cells[row : row + 4, column : column + 3] = rng.integers(-1, 101)
        grid = Grid(cells, (0.1 * cells.shape[0], 0.0), 0.05)
        sent = json.loads(json.dumps(grid.as_json(before)))
        assert sent['patch'] is (before is not None and before.cells.shape == cells.shape)
        picture, before = applied(picture, sent), grid
        np.testing.assert_array_equal(picture, cells)


def test_every_message_becomes_strict_json_whatever_its_numbers():
    point = message('geometry_msgs/msg/Point', x=math.nan, y=np.float64(math.inf), z=1.23456789)
    assert json.loads(json.dumps(plain(point), allow_nan=False)) == {'x': None, 'y': None, 'z': 1.23457}
    assert plain(np.array([1, 2], np.int8)) == [1, 2]


@pytest.mark.parametrize('channel', CHANNELS, ids=lambda channel: channel.name)
def test_damaged_messages_are_dropped_and_the_rest_is_shown(channel, caplog):
    board, seen = Board(), Seen(pictures=[channel.name])
    for raw in (b'', b'\0\1\0\0', bytes(64), b'\0\1\0\0' + b'\xff' * 200):
        board.put(channel, raw)
        board.update()
        json.loads('{' + board.news(seen) + '}')
        assert list(board.pictures(seen)) == []


def test_a_page_gets_each_value_once():
    board, seen = Board(), Seen()
    text = jazzy_types().serialize_cdr(message('std_msgs/msg/String', data='a'), 'std_msgs/msg/String')
    board.put(Channel('monitor', 'x', 'std_msgs/msg/String'), bytes(text))
    board.update()
    assert json.loads('{' + board.news(seen) + '}') == {'monitor': {'data': 'a'}}
    seen.version = board.version
    assert board.news(seen) == ''
