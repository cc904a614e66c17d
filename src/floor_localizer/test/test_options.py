"""Tasks in local worker processes: their errors are raised here and not printed elsewhere."""

import os
import signal
import time

import pytest

from floor_localizer.commands import options as task_runner_module
from floor_localizer.commands.options import task_runner
from floor_localizer.core.errors import FloorLocalizerError

pytestmark = pytest.mark.newest_set_only


def test_errors_of_workers_are_raised_and_logged_only_here(tmp_path, capfd):
    with task_runner(2) as runner:
        with pytest.raises(FileNotFoundError) as fault:
            list(runner.run(os.mkdir, [(str(tmp_path / 'a'),), (str(tmp_path / 'none' / 'b'),)]))
        assert fault.value.filename == str(tmp_path / 'none' / 'b')
        with pytest.raises(FloorLocalizerError, match='a worker died'):
            list(runner.run(signal.raise_signal, [(int(signal.SIGKILL),)]))
        # Restarted workers run the other tasks.
        assert len(list(runner.run(os.mkdir, [(str(tmp_path / f'{k}'),) for k in range(4)]))) == 4
    assert (tmp_path / '3').is_dir()
    assert capfd.readouterr() == ('', '')


def test_a_cluster_without_dask_is_an_error_in_one_line(monkeypatch):
    monkeypatch.setattr(task_runner_module, 'find_spec', lambda _: None)
    with pytest.raises(FloorLocalizerError, match='pip install dask distributed'):
        task_runner(2, 'tcp://127.0.0.1:1').__enter__()


def test_a_scheduler_without_workers_or_that_stops_is_an_error(monkeypatch):
    distributed = pytest.importorskip('distributed')
    monkeypatch.setattr(task_runner_module, '_SCHEDULER_TIMEOUT', 2.0)
    with distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        with pytest.raises(FloorLocalizerError, match=f'start "dask worker {address}"'):
            task_runner(1, address).__enter__()
        cluster.scale(1)
        with task_runner(1, address) as runner:
            tasks = runner.run(time.sleep, [(0.0,), (3.0,)])
            next(tasks)
            cluster.close()
            with pytest.raises(FloorLocalizerError, match='the scheduler has stopped; start it and run the same'):
                next(tasks)
    with pytest.raises(FloorLocalizerError, match='does not answer'):
        task_runner(1, address).__enter__()
