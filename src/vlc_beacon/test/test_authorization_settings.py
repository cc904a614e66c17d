from shirube_core.settings import check_settings
from vlc_beacon.core.authorization.authorization_settings import AuthorizationSettings


def test_the_defaults_are_within_their_ranges() -> None:
    check_settings(AuthorizationSettings())
