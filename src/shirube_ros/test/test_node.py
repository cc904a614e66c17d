"""The main function of a node."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from domain_coordinator import domain_id

pytestmark = pytest.mark.newest_set_only

PROGRAM = Path(__file__).with_name('minimal_node.py')


@pytest.fixture
def environment() -> Iterator[dict[str, str]]:
    with domain_id() as domain:
        yield os.environ | {'ROS_DOMAIN_ID': str(domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}


def start(environment: dict[str, str], *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, PROGRAM, *arguments],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


STOPPED = 'stopped while publishers work'


# Each pair of a signal, a number of signals and a state of the node.
@pytest.mark.parametrize(
    ('number', 'times', 'fault', 'ending'),
    [
        (signal.SIGINT, 1, 'slow', []),
        (signal.SIGTERM, 2, 'slow', []),
        (signal.SIGINT, 2, 'compiling', []),
        (signal.SIGTERM, 1, 'compiling', []),
        *((number, times, 'none', [STOPPED]) for number in (signal.SIGINT, signal.SIGTERM) for times in (1, 2)),
        *((signal.SIGINT, times, 'busy', ['worked to the end', STOPPED]) for times in (1, 2)),
    ],
)
def test_a_signal_ends_the_node_cleanly_after_its_work_and_while_publishers_work(
    environment: dict[str, str], number: int, times: int, fault: str, ending: list[str]
) -> None:
    program = start(environment, '--ros-args', '-p', f'fault:={fault}')
    assert program.stdout is not None
    assert program.stdout.readline() == 'alive\n'
    for _ in range(times):
        os.killpg(program.pid, number)
        time.sleep(0.1 if fault == 'busy' else 0.001)
    words, errors = program.communicate(timeout=20)
    assert program.returncode == 0, errors
    assert 'Traceback' not in errors
    assert [line for line in words.splitlines() if line != 'alive'][-2:] == ending
    assert words.count('stopped') == len([*filter(STOPPED.__eq__, ending)])


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_during_the_imports_ends_the_node_without_a_traceback(
    number: int, tmp_path: Path, environment: dict[str, str]
) -> None:
    package = tmp_path / 'big_package'
    package.mkdir()
    (package / '__init__.py').touch()
    (package / 'node.py').write_text('import time\nprint("importing", flush=True)\ntime.sleep(60.0)\n')
    program = subprocess.Popen(
        [sys.executable, '-c', 'from shirube_ros.start import big_package\nbig_package()'],
        env=environment | {'PYTHONPATH': str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert program.stdout is not None
    assert program.stdout.readline() == 'importing\n'
    program.send_signal(number)
    assert (program.communicate(timeout=20)[1], program.returncode) == ('', 0)


def test_stop_is_called_after_an_internal_error(environment: dict[str, str]) -> None:
    program = start(environment, '--ros-args', '-p', 'fault:=later')
    words, errors = program.communicate(timeout=20)
    assert program.returncode == 1
    assert 'ZeroDivisionError: a mistake' in errors
    assert words.splitlines()[-1] == STOPPED


@pytest.mark.parametrize(
    ('arguments', 'line'),
    [
        (['-p', 'rate:=7.0'], 'minimal: setting rate is 7.0, allowed is 0 to 1 (rate)'),
        (['-p', 'fault:=file'], "minimal: [Errno 2] No such file or directory: 'no_such_file.csv'"),
        (['-p', 'fault:=package'], 'minimal: map.csv is empty; build a map'),
        (
            ['-p', 'rates:=[0, 0.5]'],
            'minimal: -p rates is [0, 0.5], which mixes whole and decimal numbers; write [0.0, 0.5]',
        ),
        (
            ['--', '-p', 'rate:=0.5'],
            'minimal: -p rate:=0.5 has no effect here; write --ros-args -p rate:=0.5 (--help shows how)',
        ),
    ],
)
def test_a_start_error_is_one_line_and_exit_code_1(
    environment: dict[str, str], arguments: list[str], line: str
) -> None:
    program = start(environment, '--ros-args', *arguments)
    _, errors = program.communicate(timeout=20)
    assert program.returncode == 1
    assert errors.splitlines() == [line]


def test_help_starts_no_node(environment: dict[str, str]) -> None:
    program = start(environment, '--help')
    words, errors = program.communicate(timeout=20)
    assert (program.returncode, errors) == (0, '')
    assert words.startswith('usage: ')


@pytest.mark.parametrize('home', ['/proc/none', '/dev/null/none'])
def test_a_home_that_cannot_be_written_to_is_a_warning(environment: dict[str, str], home: str) -> None:
    environment = {name: value for name, value in environment.items() if name != 'ROS_LOG_DIR'}
    program = start(environment | {'HOME': home}, '--ros-args', '-p', 'fault:=none')
    assert program.stdout is not None
    assert program.stdout.readline() == 'alive\n'
    os.killpg(program.pid, signal.SIGTERM)
    _, errors = program.communicate(timeout=20)
    assert program.returncode == 0
    (line,) = errors.splitlines()
    assert 'set ROS_LOG_DIR to a writable folder' in line


@pytest.mark.parametrize('arguments', [['-p', 'rate'], ['--params-file', 'none.yaml'], ['-r', '__node:=a b']])
def test_bad_ros_arguments_end_in_one_line_and_exit_code_1(environment: dict[str, str], arguments: list[str]) -> None:
    program = start(environment, '--ros-args', *arguments)
    _, errors = program.communicate(timeout=20)
    assert program.returncode == 1
    *from_rcl, line = errors.splitlines()
    assert line.startswith('minimal: ')
    assert arguments[-1] in line
    assert all('[rcl]' in other for other in from_rcl)


def test_a_mistake_in_the_program_is_not_hidden(environment: dict[str, str]) -> None:
    program = start(environment, '--ros-args', '-p', 'fault:=program')
    _, errors = program.communicate(timeout=20)
    assert program.returncode == 1
    assert 'Traceback' in errors
    assert 'ZeroDivisionError: a mistake' in errors
