"""The exception of this package."""


class SettingsError(ValueError):
    """A setting has a wrong type, is out of range or does not exist; the message is one line."""
