"""Valid YAML is read, invalid YAML is rejected quickly with one short line."""

import math

import pytest

from shirube_core.files import YamlFileError, format_value, is_number, read_yaml

BOMB = 'a: &a [x, x, x, x, x, x, x, x, x]\n' + ''.join(
    f'{name}: &{name} [{", ".join(["*" + before] * 9)}]\n' for before, name in zip('abcdefgh', 'bcdefghi')
)


@pytest.mark.parametrize(
    ('text', 'fields'),
    [
        ('image: µ.pgm\norigin: [0.5, 1, -2]\n', {'image': 'µ.pgm', 'origin': [0.5, 1, -2]}),
        # PyYAML writes an alias if a list is used twice.
        ('a: &id001 [4.0, 8.0]\nb: *id001\n', {'a': [4.0, 8.0], 'b': [4.0, 8.0]}),
        ('a: &a {x: 1, y: 2}\nb: {<<: *a, x: 3}\n', {'a': {'x': 1, 'y': 2}, 'b': {'x': 3, 'y': 2}}),
    ],
)
def test_fields_are_read(tmp_path, text, fields):
    (tmp_path / 'a.yaml').write_text(text, encoding='utf-8')
    assert read_yaml(tmp_path / 'a.yaml') == fields


@pytest.mark.parametrize(
    ('data', 'words'),
    [
        (b'', 'holds no fields'),
        (b'[1, 2]', 'holds no fields'),
        (b'a: 1\nb: 2\na: 3', 'a appears twice in line 3'),
        (b'a: [{b: 1, b: 1}]', 'b appears twice in line 1'),
        (b'a: "\\q"', 'in line 1'),
        *((data, 'is no YAML') for data in (b'a: [1', b'\x00', b'\xff\xfe', b'a: 2024-13-45')),
        *((b'a: ' + data, 'is no YAML') for data in (b'[' * 1000, b'9' * 5000, b'!!python/object:os.system {}')),
        (BOMB.encode(), 'its aliases expand to too many values'),
        (b'a: &a [1, *a]', 'its aliases expand to too many values'),
        (b'a: ' + b'x' * 70000, 'holds more than 64 kB'),
    ],
)
@pytest.mark.newest_set_only
def test_an_invalid_file_is_rejected_in_one_line(tmp_path, data, words):
    path = tmp_path / 'a.yaml'
    path.write_bytes(data)
    with pytest.raises(YamlFileError) as caught:
        read_yaml(path)
    assert words in str(caught.value)
    assert str(caught.value).startswith(f'{path}: ')
    assert '\n' not in str(caught.value)
    assert len(str(caught.value)) < len(str(path)) + 200


def test_a_larger_file_may_be_asked_for(tmp_path):
    path = tmp_path / 'a.yaml'
    path.write_text('a: ' + 'x' * 70000)
    assert len(read_yaml(path, 1 << 20)['a']) == 70000


def test_a_missing_file_is_reported(tmp_path):
    with pytest.raises(YamlFileError, match=r'cannot be read \(No such file'):
        read_yaml(tmp_path / 'none.yaml')
    with pytest.raises(YamlFileError, match='cannot be read'):
        read_yaml(tmp_path / 'a\0b')


def test_long_values_are_shown_in_part():
    assert format_value('raw') == "'raw'"
    assert format_value([1.5, None]) == '[1.5, None]'
    assert len(format_value('x' * 1000)) == 80


def test_only_finite_numbers_are_numbers():
    assert all(is_number(value) for value in (0, -1.5, 10**300))
    assert not any(is_number(value) for value in (True, None, '1', [1], math.nan, -math.inf, 10**400))
