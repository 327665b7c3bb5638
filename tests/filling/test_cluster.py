"""A dask cluster: the same catalogue as without it, and one line for each kind of failure."""

import json
import socketserver
import sys
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING

import pytest
from contents import rows
from workforce import Deadly, Failing, filled_by

from orbitdb import __version__
from orbitdb.errors import InputError, WorkError
from orbitdb.filling.cluster import Cluster
from orbitdb.filling.workers import HERE

if TYPE_CHECKING:  # importing it takes a second
    from distributed import LocalCluster

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")


@pytest.fixture(scope="module")
def local_cluster() -> Iterator["LocalCluster"]:
    """Two worker processes that restart when they die; the scheduler runs in this process."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as cluster:
        yield cluster


@pytest.mark.slow
@pytest.mark.usefixtures("small_blocks")
def test_a_cluster_of_two_threads_fills_a_catalogue(tmp_path, monkeypatch, cli):
    """The cluster's address, results, failures and blocks in flight are checked, and then its loss."""
    from distributed import LocalCluster, default_client

    file = tmp_path / "scheduler.json"
    for content in ("", "{}", "[]", "\0"):
        file.write_text(content)
        with pytest.raises(InputError, match="was not written by a dask scheduler"):
            Cluster(str(file)).__enter__()
    alone = filled_by(HERE, tmp_path / "alone.db", periods=(6,))
    options = {"processes": False, "protocol": "tcp", "dashboard_address": None}
    with LocalCluster(n_workers=1, threads_per_worker=2, **options) as cluster:
        file.write_text(json.dumps({"address": cluster.scheduler_address}))
        with Cluster(str(file)) as workers:
            assert (workers.jobs, workers.size()) == (2, (1, 2))
            with pytest.raises(ValueError, match="No client"):
                default_client()  # Dask's default client may be the user's own
            assert rows(filled_by(workers, tmp_path / "shared.db", periods=(6,))) == rows(alone)
            blocks = (partial(int, i) for i in range(20))
            going = workers.solved(blocks)
            assert [next(going) for _ in range(3)] == [0, 1, 2]
            assert next(blocks)() == 7  # two blocks per thread are in flight, besides the one asked for
            for _ in range(2):  # each submission is a new task; otherwise the first failure would be reused
                with pytest.raises(WorkError, match=r"not solve a block: ZeroDivisionError: by nothing$"):
                    list(workers.solved([Failing()]))
            with pytest.raises(WorkError, match=f"install orbitdb {__version__} there"):
                list(workers.solved([partial(import_module, "orbitdb.nothing")]))
            told = cli("fill", "--p", "5", "--a", "1", "--scheduler", str(file))
            assert told.code == 0
            assert "worker" in told.err
            workers._client.close()
            for ask in (workers.size, lambda: next(workers.solved([int]))):
                with pytest.raises(WorkError, match="connection to the dask scheduler was lost"):
                    ask()
        wait_until(lambda: not cluster.scheduler.tasks)
    monkeypatch.setattr("orbitdb.filling.cluster.SCHEDULER_PATIENCE", 0.5)
    with pytest.raises(InputError, match=f"answers at {cluster.scheduler_address}: give"):
        Cluster(str(file)).__enter__()
    with pytest.raises(InputError, match=r"answers at foo://there:1 \(.+\): give"):
        Cluster("foo://there:1").__enter__()


@pytest.mark.slow
def test_a_block_that_kills_its_workers_is_given_up(local_cluster, monkeypatch):
    from distributed import Client

    monkeypatch.setattr(local_cluster.scheduler, "allowed_failures", 1)
    with Client(local_cluster) as client, Cluster(local_cluster.scheduler_address) as workers:
        with pytest.raises(WorkError, match="died 2 times on the same block"):
            list(workers.solved([Deadly()]))
        client.wait_for_workers(2)  # a cluster cannot close while it restarts a worker
    wait_until(lambda: not {key for key in local_cluster.scheduler.clients if "Client" in key})


def wait_until(happened: Callable[[], bool], seconds: float = 120) -> None:
    deadline = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < deadline
        time.sleep(0.05)


class Silent(socketserver.BaseRequestHandler):
    """Accepts data and never answers."""

    def handle(self) -> None:
        while self.request.recv(1024):
            pass


@pytest.mark.parametrize("listens", [False, True])
@pytest.mark.slow
def test_a_missing_scheduler_is_reported_in_one_line(tmp_path, monkeypatch, cli, listens):
    monkeypatch.setattr("orbitdb.filling.cluster.SCHEDULER_PATIENCE", 0.5)
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Silent, bind_and_activate=listens) as server:
        server.daemon_threads = True
        address = f"127.0.0.1:{server.server_address[1] or 1}"
        if listens:
            threading.Thread(target=server.serve_forever, daemon=True).start()
        found = cli("fill", "--p", "5", "--scheduler", address)
        if listens:
            server.shutdown()
    assert found.code == 2
    assert found.err.count("\n") == 1
    assert f"no dask scheduler answers at {address}" in found.err
    assert not (tmp_path / "orbits.db").exists()


def test_without_dask_the_extra_is_named(cli, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    found = cli("fill", "--p", "5", "--scheduler", "127.0.0.1:8786")
    assert found.code == 1
    assert found.err == "orbitdb: a cluster needs distributed: pip install 'orbitdb[dask]'\n"
