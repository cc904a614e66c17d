"""The pose arbiter on recorded and simulated drives: `./shirube bench arbiter [PART ...] [--seeds N]`.

Parts: `bags` (the fused pose against its source, odometry alone and gtsam), `faults`, `order`, `bad`, `load`; or all.
"""

from __future__ import annotations

import argparse
import random
import sys
import time

import numpy as np
from _arbiter_bags import PoseSample, RecordedDrive, recorded_drives
from _arbiter_faults import FAULTS, SCENARIOS, wrong_poses
from _arbiter_fusion import Message, add_message, fused, messages_of, new_arbiter, pose_of
from _arbiter_load import filter_cpu_fraction, node_cpu_fraction
from _arbiter_smoother import INSTALL, IS_INSTALLED, smooth

from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.kalman_filter import Estimate, diagonal
from pose_arbiter.core.settings import ArbiterSettings
from shirube_core.geometry import SE2

OUTAGE_FROM, OUTAGE_TO = 0.4, 0.8
"""Fractions of the drive between which the source is silent."""
BAD_MESSAGES = 100_000


def main() -> int:
    """Print the tables of the named parts."""
    parser = argparse.ArgumentParser(prog='arbiter', description=__doc__)
    parser.add_argument('parts', nargs='*', help='bags, faults, order, bad, load')
    parser.add_argument('--seeds', type=int, default=20, help='drives for each fault (default: %(default)s)')
    options = parser.parse_args()
    wanted = options.parts or ['bags', 'faults', 'order', 'bad', 'load']
    if 'bags' in wanted:
        print_bags(recorded_drives())
    if 'faults' in wanted:
        print_faults(options.seeds)
    if 'order' in wanted or 'bad' in wanted:
        (drive,) = recorded_drives(['room_drive'])
        print(f'shuffled arrival: largest difference {largest_difference(drive):.1e}')
        print(f'{BAD_MESSAGES} bad messages: largest difference {difference_by_bad_messages(drive):.1e}')
    if 'load' in wanted:
        print(f'filter: {filter_cpu_fraction():.1%} of a core')
        cpu_fraction, rate = node_cpu_fraction()
        print(f'node: {cpu_fraction:.1%} of a core, {rate:.1f} poses a second')
    return 0


def print_bags(drives: list[RecordedDrive]) -> None:
    """Print one line per bag: root mean square errors of position [mm] and yaw [mrad]."""
    print(
        '| bag | poses | source | fused | fused / source | gtsam | fused / gtsam | outage: fused | odometry alone |'
    )
    print('|---|---|---|---|---|---|---|---|---|')
    for drive in drives:
        best, count = drive.best, len(drive.sources)
        source = drive.errors_of(drive.sources[best])
        estimates = fused(messages_of(drive.sources, drive.odometry), count, best)
        ours = drive.errors_at([s for s, _ in estimates], [pose_of(e) for _, e in estimates])
        a, b = rms(source), rms(ours)
        d, e = (rms(errors) for errors in outage_errors(drive))
        cells = [cell(a), cell(b), ratio(b, a), *compare_with_gtsam(drive, b), cell(d), cell(e)]
        print(f'| {drive.name} | {len(source)} |', ' | '.join(cells), '|', flush=True)
    if not IS_INSTALLED:
        print(INSTALL)


def compare_with_gtsam(drive: RecordedDrive, ours: tuple[float, float]) -> tuple[str, str]:
    """Return the errors of gtsam's newest states, and the ratio of ours to them; dashes where it is not installed."""
    if not IS_INSTALLED:
        return '-', '-'
    newest = smooth(drive.sources, drive.odometry, drive.best)
    theirs = rms(drive.errors_at(*map(list, zip(*newest, strict=True))))
    return cell(theirs), ratio(ours, theirs)


def outage_errors(drive: RecordedDrive) -> tuple[np.ndarray, np.ndarray]:
    """Return the errors, shape (n, 2), through an outage: of the arbiter, and of odometry since the first pose."""
    samples = sorted((o for source in drive.sources for o in source), key=lambda o: o.stamp)
    first, last = samples[0].stamp, samples[-1].stamp
    begin, end = (round(first + part * (last - first)) for part in (OUTAGE_FROM, OUTAGE_TO))
    received = [[o for o in source if not begin < o.stamp <= end] for source in drive.sources]
    silent = {o.stamp for o in samples if begin < o.stamp <= end}
    at_end = messages_of(received, [pair for pair in drive.odometry if pair[0] <= end])
    arbiter, poses = new_arbiter(len(received)), []
    waiting = sorted(silent)
    for message in at_end:
        while waiting and message[0] >= waiting[0]:
            stamp = waiting.pop(0)
            estimate = arbiter.estimate_at(stamp)
            if estimate is not None:
                poses.append((stamp, pose_of(estimate)))
        add_message(arbiter, message, message[0])
    stamps = np.array([stamp for stamp, _ in drive.odometry])
    content = [pose for _, pose in drive.odometry]
    origin = (
        samples[0].pose @ content[int(np.searchsorted(stamps, first).clip(0, len(content) - 1))].inverse()
    )
    nearest = [content[int(np.searchsorted(stamps, s).clip(0, len(content) - 1))] for s, _ in poses]
    ours = drive.errors_at([s for s, _ in poses], [p for _, p in poses])
    return ours, drive.errors_at([s for s, _ in poses], [origin @ p for p in nearest])


def print_faults(seeds: int) -> None:
    """Print how many drives had more than three wrong poses, and the most in one drive."""
    print('| sources | ' + ' | '.join(FAULTS) + ' |')
    print('|---' * (len(FAULTS) + 1) + '|')
    for scenario in SCENARIOS:
        cells = []
        for fault in FAULTS:
            wrong = [wrong_poses(scenario, fault, seed)[0] for seed in range(seeds)]
            cells.append(f'{sum(w > 3 for w in wrong)} of {seeds}, {max(wrong)}')
        print(f'| {scenario.name} | ' + ' | '.join(cells) + ' |', flush=True)


def largest_difference(drive: RecordedDrive, shuffles: int = 5) -> float:
    """Return how far the last poses of shuffled drives differ from that of the drive in order."""
    (samples,) = drive.sources
    messages = messages_of([samples[::2], samples[1::2]], drive.odometry)
    settings, now = ArbiterSettings(history_seconds=30.0), messages[-1][0]
    ends = []
    for seed in range(shuffles + 1):
        arbiter, order = new_arbiter(2, settings), list(messages)
        if seed:
            random.Random(seed).shuffle(order)  # noqa: S311
        for message in order:
            add_message(arbiter, message, now)
        ends.append([[*e[1:4], *e.covariance] for t in np.linspace(messages[0][0], now, 50)
                     if (e := arbiter.estimate_at(int(t))) is not None])  # fmt: skip
    return float(max(np.abs(np.array(end) - ends[0]).max() for end in ends))


def difference_by_bad_messages(drive: RecordedDrive) -> float:
    """Return how far poses, covariances and biases differ with many random invalid messages in between."""
    rng, messages = random.Random(1), messages_of(drive.sources, drive.odometry)  # noqa: S311
    plain, disturbed, worst = new_arbiter(1), new_arbiter(1), 0.0
    each = BAD_MESSAGES // len(messages) + 1
    for message in messages:
        now = message[0]
        for arbiter in (plain, disturbed):
            add_message(arbiter, message, now)
        for _ in range(each):
            if is_accepted(disturbed, bad_message(rng, message), now):
                raise ValueError('a bad message was accepted')
        a, b = plain.estimate_at(now), disturbed.estimate_at(now)
        if a is not None and b is not None:
            worst = max(worst, float(np.abs(state_of(a) - state_of(b)).max()))
    return worst


def is_accepted(arbiter: Arbiter, message: Message, now: int) -> bool:
    """Add a message to an arbiter; return whether it was accepted."""
    try:
        add_message(arbiter, message, now)
    except ValueError:
        return False
    return True


def state_of(estimate: Estimate) -> np.ndarray:
    """Return pose, biases and covariance as one array."""
    return np.concatenate((estimate[1:4], estimate.bias.ravel(), estimate.P.ravel()))


def bad_message(rng: random.Random, latest: Message) -> Message:
    """Return a pose or odometry with one fault: a number, a covariance, a stamp, or one that the latest message had."""
    now, source, content = latest
    pose, noise, stamp = [rng.gauss(0.0, 10.0) for _ in range(3)], diagonal(1e-4, 1e-4), now
    is_odometry = rng.random() < 0.5
    match rng.randrange(5):
        case 0:
            pose[rng.randrange(3)] = rng.choice([float('nan'), float('inf'), float('-inf')])
        case 1:
            pose[rng.randrange(2)] = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(6.1, 300.0)
        case 2:
            is_odometry = False
            noise = diagonal(
                rng.choice([0.0, -1.0, float('nan'), 1e9]), rng.choice([0.0, -1.0, float('inf')])
            )
        case 3:
            stamp = rng.choice([0, -1, now + rng.randrange(10**9, 10**18), rng.randrange(1, now - 3 * 10**9)]) \
                if now > 4 * 10**9 else 0  # fmt: skip
        case _:
            is_odometry = isinstance(content, SE2)
    pose_value = SE2(*pose)
    return (
        stamp,
        source if is_odometry else 0,
        pose_value if is_odometry else PoseSample(stamp, pose_value, noise),
    )


def rms(errors: np.ndarray) -> tuple[float, float]:
    """Return root mean squares of position [mm] and heading [mrad], of what is known."""
    position, heading = 1e3 * np.sqrt(np.nanmean(errors**2, axis=0))
    return float(position), float(heading)


def ratio(a: tuple[float, float], b: tuple[float, float]) -> str:
    """Return by how much position and heading of one are off more than those of the other."""
    return f'{a[0] / b[0]:.3f}, {a[1] / b[1]:.3f}'


def cell(pair: tuple[float, float]) -> str:
    """Return two numbers with three digits."""
    return f'{pair[0]:.3g}, {pair[1]:.3g}'


if __name__ == '__main__':
    begun = time.monotonic()
    code = main()
    print(f'took {time.monotonic() - begun:.0f} s', file=sys.stderr)
    sys.exit(code)
