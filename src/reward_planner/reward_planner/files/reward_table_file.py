"""Rewards along a path as CSV: eight lines per cell, one for each step."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.reward.explained_walk import ExplainedCell
from reward_planner.core.reward.step_reward import TERM_NAMES
from shirube_core.files import write_text

_HEAD = ('number', 'x', 'y', 'to_x', 'to_y', *TERM_NAMES, 'total', 'can_enter', 'taken')


def save_reward_table(path: Path, cells: Iterable[ExplainedCell], frame: GridFrame) -> None:
    """Write the rewards atomically, with positions in the map frame [m].

    Args:
        path: output file.
        cells: cells of the path in order.
        frame: geometry of the map.

    Raises:
        OSError: the file cannot be written.
    """
    lines = [','.join(_HEAD)]
    for number, at in enumerate(cells):
        x, y = frame.centre_of(at.cell)
        for reward in at.rewards:
            rows, columns = reward.step
            to_x, to_y = x + columns * frame.resolution, y + rows * frame.resolution
            terms = (f'{reward.terms.get(name, 0.0):.3f}' for name in TERM_NAMES)
            flags = (int(reward.can_enter), int(reward.step == at.taken))
            places = (f'{place:.4f}' for place in (x, y, to_x, to_y))
            lines.append(','.join(map(str, (number, *places, *terms, f'{reward.total:.3f}', *flags))))
    write_text(path, '\n'.join([*lines, '']))
