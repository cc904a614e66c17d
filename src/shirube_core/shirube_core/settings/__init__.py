"""Typed settings: a frozen dataclass defines default, unit, range and description of each value once."""

from shirube_core.settings.build import check_settings, reject_former_option, renamed_message, settings_from_values
from shirube_core.settings.definition import SettingDescription, SettingsError, describe_settings, setting, tunable

__all__ = [
    'SettingDescription',
    'SettingsError',
    'check_settings',
    'describe_settings',
    'reject_former_option',
    'renamed_message',
    'setting',
    'settings_from_values',
    'tunable',
]
