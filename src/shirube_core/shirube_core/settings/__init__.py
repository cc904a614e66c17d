"""Typed settings: a frozen dataclass defines default, unit, range and description of each value once."""

from shirube_core.settings.build import renamed_message, settings_from_values
from shirube_core.settings.check import check_settings
from shirube_core.settings.definition import SettingDescription, describe_settings, setting
from shirube_core.settings.markdown import settings_table
from shirube_core.settings.renamed_option import reject_former_option
from shirube_core.settings.settings_error import SettingsError

__all__ = [
    'SettingDescription',
    'SettingsError',
    'check_settings',
    'describe_settings',
    'reject_former_option',
    'renamed_message',
    'setting',
    'settings_from_values',
    'settings_table',
]
