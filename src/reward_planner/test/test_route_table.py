"""Tests of routes as CSV."""

from pathlib import Path

import numpy as np

from reward_planner.files.route_files import save_route_table


def test_a_table_has_a_header_and_a_line_a_point_in_metres(tmp_path: Path) -> None:
    save_route_table(tmp_path / 'new' / 'route.csv', np.array([[0.025, -1.0], [0.075, -0.95]]))
    assert (tmp_path / 'new' / 'route.csv').read_text() == 'x,y\n0.0250,-1.0000\n0.0750,-0.9500\n'
