"""Files are complete or unchanged."""

import pytest

from shirube_core.files import atomic_write, remove_temporary_files, write_text


def test_a_file_is_replaced_and_nothing_else_is_left(tmp_path):
    write_text(tmp_path / 'new' / 'a.txt', 'old')
    write_text(tmp_path / 'new' / 'a.txt', 'µ')
    assert (tmp_path / 'new' / 'a.txt').read_text(encoding='utf-8') == 'µ'
    assert len(list((tmp_path / 'new').iterdir())) == 1


def test_a_failure_leaves_the_old_file(tmp_path):
    write_text(tmp_path / 'a.txt', 'old')
    with pytest.raises(UnicodeEncodeError):
        write_text(tmp_path / 'a.txt', 'lone surrogate \ud800')
    assert (tmp_path / 'a.txt').read_text() == 'old'
    assert len(list(tmp_path.iterdir())) == 1


def test_the_file_is_as_readable_as_any_other(tmp_path):
    (tmp_path / 'plain').touch()
    write_text(tmp_path / 'a.txt', 'x')
    assert (tmp_path / 'a.txt').stat().st_mode == (tmp_path / 'plain').stat().st_mode


def test_a_file_keeps_its_permissions(tmp_path):
    path = tmp_path / 'secret'
    write_text(path, 'one')
    path.chmod(0o600)
    write_text(path, 'two')
    assert path.read_text() == 'two'
    assert path.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize('name', ['/proc/a.txt', 'folder'])
def test_an_error_names_the_file_that_was_wanted(tmp_path, name):
    path = tmp_path / name
    if name == 'folder':
        path.mkdir()
    with pytest.raises(OSError, match=f": '{path}'$") as caught:
        write_text(path, 'x')
    assert caught.value.filename == str(path)


def test_what_a_killed_process_left_half_written_is_removed(tmp_path):
    (tmp_path / '.a.txt.swp').touch()  # swap file of an editor
    writing = atomic_write(tmp_path / 'a.txt')
    writing.__enter__()
    remove_temporary_files(tmp_path, 'b.txt')
    assert len(list(tmp_path.iterdir())) == 2
    remove_temporary_files(tmp_path, '*.txt')
    assert [path.name for path in tmp_path.iterdir()] == ['.a.txt.swp']
    with pytest.raises(FileNotFoundError):
        writing.__exit__(None, None, None)
