import numpy as np

from vlc_beacon.core.receiver.patience import REST, Patience

LISTEN = 15.0


def test_silence_is_listened_to_less_and_less_but_never_for_ever():
    patience = Patience(LISTEN)
    stamps = np.arange(0.0, 10.0 * (LISTEN + REST), 0.1)
    listened = np.array([patience.listens(stamp) for stamp in stamps])
    assert listened[stamps < LISTEN].all()
    assert listened.mean() < 1.05 * LISTEN / (LISTEN + REST)
    last = stamps >= stamps[-1] - LISTEN - REST
    assert listened[last].any()
    assert patience.is_over


def test_whoever_speaks_is_listened_to():
    patience = Patience(LISTEN)
    for stamp in np.arange(0.0, 100.0, 0.5):
        assert patience.listens(stamp)
        assert not patience.is_over
        if stamp % 10.0 == 0.0:
            patience.hear(stamp)


def test_a_lamp_that_begins_to_speak_is_taken_up_again():
    patience = Patience(LISTEN)
    stamp = 0.0
    while patience.listens(stamp) or stamp < LISTEN + 1.0:
        stamp += 0.5
    assert patience.is_over
    while not patience.listens(stamp):
        stamp += 0.5
    patience.hear(stamp)
    assert not patience.is_over
    assert patience.listens(stamp + LISTEN - 0.1)
