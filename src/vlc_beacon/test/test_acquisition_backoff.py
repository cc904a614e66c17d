import numpy as np

from vlc_beacon.core.receiver.acquisition_backoff import BACKOFF_TIME, AcquisitionBackoff

LISTEN = 15.0


def test_acquisition_pauses_and_restarts():
    backoff = AcquisitionBackoff(LISTEN)
    stamps = np.arange(0.0, 10.0 * (LISTEN + BACKOFF_TIME), 0.1)
    listened = np.array([backoff.is_active(stamp) for stamp in stamps])
    assert listened[stamps < LISTEN].all()
    assert listened.mean() < 1.05 * LISTEN / (LISTEN + BACKOFF_TIME)
    last = stamps >= stamps[-1] - LISTEN - BACKOFF_TIME
    assert listened[last].any()
    assert backoff.has_timed_out


def test_a_lamp_with_packets_stays_active():
    backoff = AcquisitionBackoff(LISTEN)
    for stamp in np.arange(0.0, 100.0, 0.5):
        assert backoff.is_active(stamp)
        assert not backoff.has_timed_out
        if stamp % 10.0 == 0.0:
            backoff.reset(stamp)


def test_a_lamp_is_reacquired_when_it_starts_to_send():
    backoff = AcquisitionBackoff(LISTEN)
    stamp = 0.0
    while backoff.is_active(stamp) or stamp < LISTEN + 1.0:
        stamp += 0.5
    assert backoff.has_timed_out
    while not backoff.is_active(stamp):
        stamp += 0.5
    backoff.reset(stamp)
    assert not backoff.has_timed_out
    assert backoff.is_active(stamp + LISTEN - 0.1)
