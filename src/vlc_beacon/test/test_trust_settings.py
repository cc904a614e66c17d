from shirube_settings import check_settings
from vlc_beacon.core.trust.trust_settings import TrustSettings


def test_the_defaults_are_within_their_ranges() -> None:
    check_settings(TrustSettings())
