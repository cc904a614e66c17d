"""The pose arbiter on recorded drives (beside gtsam's smoother), with one faulty source, and its load.

That late and shuffled messages change nothing, and bad ones neither, is tested (`pose_arbiter/test`).
"""

import math

import numpy as np
from _arbiter_bags import PoseSample, RecordedDrive, recorded_drives
from _arbiter_faults import FAULTS, SCENARIOS, wrong_poses
from _arbiter_fusion import add_message, fused, in_order_of_arrival, messages_of, new_arbiter, smooth
from _figures import Figure, measured, rate, rms
from _harness import Option, Run, cpu_time, progress, run_benchmark
from numpy.typing import NDArray

from pose_arbiter.core.kalman_filter import diagonal
from shirube_core.geometry import SE2

OUTAGE_FROM, OUTAGE_TO = 0.4, 0.8  # fractions of the drive between which the source is silent
WRONG_MIN = 3  # A drive with more wrong poses counts
ODOMETRY_RATE, SOURCES, SOURCE_RATE = 500, 4, 30
DELAY = 80_000_000  # from an image to its pose, differing by a tenth from source to source [ns]


def add_bags(run: Run, drives: list[RecordedDrive]) -> None:
    """Add the errors of source, arbiter and smoother: root mean squares of position [mm] and yaw [mrad]."""
    gtsam = run.peer('gtsam', '--no-deps gtsam')
    heads = 'bag | poses | source: mm | mrad | fused: mm | mrad | fused / source | fused / gtsam'
    table = run.table('Recorded drives', heads, 'outage: fused mm | odometry alone mm')
    for drive in progress(drives, 'bags'):
        best, count = drive.best, len(drive.sources)
        source = drive.errors_of(drive.sources[best])
        ours = drive.errors_at(fused(messages_of(drive.sources, drive.odometry), count, best))
        compared: Figure | str = '–'
        if gtsam is not None:
            newest = smooth(gtsam, drive.sources, drive.odometry, drive.best)
            compared = over(ours, drive.errors_at(newest))
        outage = (rms(errors[:, 0], '.3g', 1e3) for errors in outage_errors(drive))
        ratios = over(ours, source), compared
        table.add(drive.name, len(source), *rms_of(source), *rms_of(ours), *ratios, *outage)


def rms_of(errors: NDArray[np.float64]) -> tuple[Figure, Figure]:
    """Return root mean squares of position [mm] and heading [mrad]."""
    return rms(errors[:, 0], '.3g', 1e3), rms(errors[:, 1], '.3g', 1e3)


def over(ours: NDArray[np.float64], theirs: NDArray[np.float64]) -> Figure:
    """Return our errors of position over the root mean square of others."""
    return rms(ours[:, 0] / math.sqrt(np.nanmean(theirs[:, 0] ** 2)))


def outage_errors(drive: RecordedDrive) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the errors, shape (n, 2), through an outage: of the arbiter, and of odometry since the first pose."""
    samples = sorted((o for source in drive.sources for o in source), key=lambda o: o.stamp)
    first, last = samples[0].stamp, samples[-1].stamp
    begin, end = (round(first + part * (last - first)) for part in (OUTAGE_FROM, OUTAGE_TO))
    received = [[o for o in source if not begin < o.stamp <= end] for source in drive.sources]
    waiting = sorted({o.stamp for o in samples if begin < o.stamp <= end})
    arbiter, poses = new_arbiter(len(received)), []
    for message in messages_of(received, [pair for pair in drive.odometry if pair[0] <= end]):
        while waiting and message[0] >= waiting[0]:
            stamp = waiting.pop(0)
            estimate = arbiter.estimate_at(stamp)
            if estimate is not None:
                poses.append((stamp, estimate.pose))
        add_message(arbiter, message, message[0])
    stamps = np.array([stamp for stamp, _ in drive.odometry])
    wanted = [first, *(stamp for stamp, _ in poses)]
    start, *nearest = (drive.odometry[int(np.searchsorted(stamps, s).clip(0, len(stamps) - 1))][1] for s in wanted)
    origin = samples[0].pose @ start.inverse()
    alone = [(stamp, origin @ pose) for (stamp, _), pose in zip(poses, nearest, strict=True)]
    return drive.errors_at(poses), drive.errors_at(alone)


def filter_cpu_fraction(seconds: float) -> float:
    """Return the processor time of the filter by the time of the drive: late poses, and 50 questions a second."""
    begin, noise, steps = 1_000_000_000_000, diagonal(1e-4, 1e-4), range(round(seconds * ODOMETRY_RATE))
    poses = [SE2(0.5 * k / ODOMETRY_RATE, 0.0, 0.0) for k in steps]
    odometry = [(begin + k * 1_000_000_000 // ODOMETRY_RATE, poses[k]) for k in steps]
    samples = []
    for number in range(SOURCES):
        stamps = [round((k + 0.2 * number) * 1e9 / SOURCE_RATE) for k in range(round(seconds * SOURCE_RATE))]
        samples.append([PoseSample(begin + at, SE2(0.5e-9 * at, 0.0, 0.0), noise) for at in stamps])
    messages = messages_of(samples, odometry)
    arrivals = in_order_of_arrival(messages, lambda source: round(DELAY * (1.0 + 0.1 * source)))

    def fuse() -> None:
        arbiter, due = new_arbiter(SOURCES), begin
        for now, message in arrivals:
            add_message(arbiter, message, now)
            if now >= due:
                arbiter.estimate_at(now)
                due += 20_000_000

    return 1e-3 * cpu_time(fuse)[1] / seconds


def main(run: Run, bags: tuple[str, ...], drives: int, scenarios: int, seconds: float) -> None:
    """Measure accuracy, faults and load."""
    add_bags(run, recorded_drives(() if bags == ('all',) else bags))
    table = run.table('Faulty sources: drives with wrong poses', 'sources', *FAULTS)
    for scenario in progress(SCENARIOS[-scenarios:], 'faults'):
        cells = []
        for fault in FAULTS:
            wrong = [wrong_poses(scenario, fault, seed) for seed in range(drives)]
            cells.append(rate(sum(number > WRONG_MIN for number in wrong), drives, 'lower'))
        table.add(scenario.name, *cells)
    table = run.table('Load: odometry at 500 Hz, four sources at 30 Hz', 'what', 'per cent of a core')
    table.add('filter', measured(100.0 * filter_cpu_fraction(seconds), '.1f'))


if __name__ == '__main__':
    run_benchmark(
        main,
        bags=Option(('all',), ('room_drive', 'mission'), 'names'),
        drives=Option(20, 1, 'for each fault'),
        scenarios=Option(len(SCENARIOS), 1, 'of the sources, from the last'),
        seconds=Option(20.0, 4.0, 'of the load'),
    )
