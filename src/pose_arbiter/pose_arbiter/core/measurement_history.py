"""The measurements of the last seconds in the order of their stamps, with the filter state after each."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter

from pose_arbiter.core.measurement_status import MeasurementStatus
from pose_arbiter.core.outlier_rejection import FilterState, OutlierRejection
from pose_arbiter.core.pose_measurement import PoseMeasurement
from shirube_core.motion import OdometryBuffer


class MeasurementHistory:
    """Rewinds to a late measurement and replays those after it; computes only when a state is asked for."""

    def __init__(self, rejection: OutlierRejection, odometry: OdometryBuffer) -> None:
        """Start without measurements.

        Args:
            rejection: one filter step with outlier rejection.
            odometry: odometry buffer, filled by the owner, who calls `invalidate_from` when it changed.
        """
        self._rejection, self._odometry = rejection, odometry
        self._base = rejection.initial_state()  # state before the first measurement
        self._measurements: list[PoseMeasurement] = []
        self._results: list[tuple[FilterState, MeasurementStatus]] = []  # of processed measurements
        self._final_counts: Counter[tuple[int, MeasurementStatus]] = Counter()  # of dropped measurements

    def contains(self, stamp: int, source: int) -> bool:
        """Return whether the history contains a pose of that stamp [ns] and source."""
        index = bisect_left(self._measurements, (stamp, source))
        return index < len(self._measurements) and self._measurements[index][:2] == (stamp, source)

    def add(self, measurement: PoseMeasurement) -> None:
        """Insert a pose by stamp; those after it are processed again."""
        index = bisect_left(self._measurements, measurement)
        self._measurements.insert(index, measurement)
        del self._results[index:]

    def invalidate_from(self, stamp: int) -> None:
        """Discard the results from a stamp [ns] on, because odometry has changed there."""
        del self._results[bisect_left(self._measurements, (stamp,)) :]

    def drop_before(self, horizon: int) -> None:
        """Make the results of poses older than a stamp [ns] final and drop the poses."""
        old = bisect_left(self._measurements, (horizon,))
        if old == 0:
            return
        self._process_pending(old)
        self._base = self._results[old - 1][0]
        for measurement, (_, status) in zip(self._measurements[:old], self._results[:old], strict=True):
            self._final_counts[measurement.source, status] += 1
        del self._measurements[:old], self._results[:old]

    def state_at(self, stamp: int) -> FilterState:
        """Return the filter state at a stamp [ns], after the poses up to it."""
        count = bisect_left(self._measurements, (stamp + 1,))
        self._process_pending(count)
        return self._results[count - 1][0] if count else self._base

    def counts(self) -> Counter[tuple[int, MeasurementStatus]]:
        """Return the number of poses by (source index, status)."""
        self._process_pending(len(self._measurements))
        return self._final_counts + Counter(
            (measurement.source, status)
            for measurement, (_, status) in zip(self._measurements, self._results, strict=True)
        )

    def _process_pending(self, count: int) -> None:
        """Process those of the first ``count`` poses that have no result yet."""
        for k in range(len(self._results), count):
            measurement = self._measurements[k]
            state = self._results[k - 1][0] if k else self._base
            self._results.append(
                self._rejection.process(state, measurement, self._odometry.lookup(measurement.stamp))
            )
