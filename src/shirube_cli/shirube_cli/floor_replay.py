"""Replays a recorded drive through the live floor localizer as fast as it keeps up."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shirube_bags.stamps import NANOSECONDS
from shirube_bags.trajectory import Trajectory, make_trajectory
from shirube_cli.error import CommandError
from shirube_cli.live_localizer import live_localizer
from shirube_cli.pose_listener import PoseListener

LOCALIZER = 'floor_localizer'
IMAGES = '/image_raw/compressed'


@dataclass(frozen=True)
class FloorReplay:
    """What came of a replay.

    Attributes:
        trajectory: the poses that the node published.
        images: how many images were replayed.
        delays: array, shape (n,), from the publication of an image to that of its pose [s].
        duration: wall time from the first image to the last pose [s].
        reasons: how many images had no pose for which reason, in the node's words.
    """

    trajectory: Trajectory
    images: int
    delays: NDArray[np.float64]
    duration: float
    reasons: dict[str, int]


def replay_floor_drive(
    root: Path, bag: Path, folder: Path, node_command: list[str] | None = None
) -> FloorReplay:
    """Replay the bag as fast as the node keeps up and return what the node made of it.

    Args:
        root: the repository, its workspace built.
        bag: the recorded drive.
        folder: takes the logs.
        node_command: program and arguments of the localizer; by default the installed node, without any.

    Raises:
        CommandError: a process failed, or no pose came; the message names the log.
    """
    with live_localizer(root, LOCALIZER, IMAGES, folder, node_command) as live:
        live.play(bag, ['--rate', '0'])
        live.listen_for_diagnostics()
        live.end()
    if not live.listener.published:
        raise CommandError(f'the node published no pose; see {live.log}')
    return _sum_up(live.listener)


def _sum_up(listener: PoseListener) -> FloorReplay:
    stamps = sorted(listener.published)
    times = [*listener.images.values(), *listener.published.values()]
    return FloorReplay(
        trajectory=make_trajectory(
            stamps,
            [listener.positions[stamp] for stamp in stamps],
            [listener.quaternions[stamp] for stamp in stamps],
        ),
        images=len(listener.images),
        delays=np.array(listener.delays) / NANOSECONDS,
        duration=(max(times) - min(times)) / NANOSECONDS,
        reasons=listener.reasons(),
    )
