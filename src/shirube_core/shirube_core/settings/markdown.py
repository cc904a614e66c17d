"""Renders a settings class as a Markdown table for the documentation."""

from __future__ import annotations

from shirube_core.settings.definition import SettingDescription, describe_settings


def settings_table(cls: type) -> str:
    """Return a Markdown table of a settings class, one row per setting, with a final newline.

    Args:
        cls: a settings dataclass; the settings of a nested one are named ``group.name``.
    """
    rows: list[tuple[str, ...]] = [('setting', 'type', 'default', 'unit', 'allowed', 'meaning'), ('---',) * 6]
    rows += [_row(description) for description in describe_settings(cls)]
    return ''.join('| ' + ' | '.join(_escape(cell) for cell in row) + ' |\n' for row in rows)


def _row(description: SettingDescription) -> tuple[str, ...]:
    return (
        f'`{description.name}`',
        description.type_name,
        f'`{_format_default(description.default)}`',
        description.unit,
        description.limits,
        description.description,
    )


def _format_default(default: object) -> str:
    """Format floats with six digits: ``3.14159`` for pi."""
    if isinstance(default, tuple):
        return '(' + ', '.join(_format_default(element) for element in default) + ')'
    return f'{default:g}' if isinstance(default, float) else repr(default)


def _escape(cell: str) -> str:
    return cell.replace('|', r'\|')
