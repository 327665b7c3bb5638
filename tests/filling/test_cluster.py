"""A dask cluster: the same catalogue as without it, and one line about whatever goes wrong with it."""

import json
import os
import signal
import socketserver
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from contents import rows
from processes import small_blocks
from workforce import Deadly, Failing, filled_by

from orbitdb import __version__
from orbitdb.errors import InputError, WorkError
from orbitdb.filling.blocks import Block
from orbitdb.filling.cluster import Cluster
from orbitdb.filling.workers import HERE
from orbitdb.symbols.counting import count_admissible

if TYPE_CHECKING:  # its import takes a second
    from distributed import LocalCluster

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")

WITHOUT_ORBITDB = """
import sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == "orbitdb":
            raise ModuleNotFoundError("No module named 'orbitdb'", name="orbitdb")
sys.meta_path.insert(0, Missing())
"""


@pytest.fixture(scope="module")
def local_cluster() -> Iterator["LocalCluster"]:
    """Two worker processes, started again when they die; the scheduler runs in this process."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as cluster:
        yield cluster


class Counting:
    """A block that says how many are under way."""

    def __init__(self, number: int) -> None:
        self.number = number

    def solved(self) -> "Counting":
        return self


@pytest.mark.slow
@pytest.mark.usefixtures("small_blocks")
def test_a_cluster_of_two_threads_in_this_process(tmp_path, monkeypatch):
    """Where it is, what it solves, what it cannot solve, how much it holds, and that it is gone."""
    from distributed import LocalCluster

    file = tmp_path / "scheduler.json"
    for content in ("", "{}", "[]", "\0"):
        file.write_text(content)
        with pytest.raises(InputError, match="not a file that a dask scheduler has written"):
            Cluster(str(file)).__enter__()
    alone = filled_by(HERE, tmp_path / "alone.db", periods=(6,))
    options = {"processes": False, "protocol": "tcp", "dashboard_address": None}
    with LocalCluster(n_workers=1, threads_per_worker=2, **options) as cluster:
        file.write_text(json.dumps({"address": cluster.scheduler_address}))
        with Cluster(str(file)) as workers:
            assert (workers.jobs, workers.size()) == (1, (1, 2))
            assert rows(filled_by(workers, tmp_path / "shared.db", periods=(6,))) == rows(alone)
            given: list[int] = []
            going = workers.solved(Counting(i) for i in range(20) if given.append(i) is None)
            assert [next(going).number for _ in range(3)] == [0, 1, 2]
            assert given == list(range(7))  # two a thread under way, beside the one that was wanted
            assert all(str(key).startswith("orbitdb-") for key in cluster.scheduler.tasks)
            for _ in range(2):  # a task of its own each, or what failed once would have failed
                with pytest.raises(WorkError, match=r"not solve a block: ZeroDivisionError: by nothing$"):
                    list(workers.solved([Failing()]))
            workers._client.close()
            with pytest.raises(WorkError, match="connection to the dask scheduler is lost"):
                workers.size()
        wait_until(lambda: not cluster.scheduler.tasks)
    monkeypatch.setattr("orbitdb.filling.cluster.PATIENCE", 0.5)
    with pytest.raises(InputError, match=f"answers at {cluster.scheduler_address}: give"):
        Cluster(str(file)).__enter__()
    with pytest.raises(InputError, match=r"answers at foo://there:1 \(.+\): give"):
        Cluster("foo://there:1").__enter__()


@pytest.mark.slow
def test_a_block_that_kills_its_workers_is_given_up(local_cluster, monkeypatch):
    from distributed import Client

    monkeypatch.setattr(local_cluster.scheduler, "allowed_failures", 1)
    with Client(local_cluster) as client, Cluster(local_cluster.scheduler_address) as workers:
        with pytest.raises(WorkError, match="died 2 times on one block"):
            list(workers.solved([Block(1.6, "newton", Deadly())]))
        client.wait_for_workers(2)  # a cluster cannot be closed while it starts a worker again


@contextmanager
def dask_scheduler(folder: Path) -> Iterator[tuple[subprocess.Popen, Callable]]:
    """A scheduler as a process of its own, which writes scheduler.json; gives it and what starts workers."""
    from distributed import Client

    file = folder / "scheduler.json"
    options = ["--scheduler-file", str(file), "--no-dashboard"]
    with ExitStack() as stack:

        def start(*kind: str, **environment: str) -> subprocess.Popen:
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", "dask", *kind, *options],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                cwd=folder,
                env=os.environ | environment,
            )
            stack.enter_context(process)
            stack.callback(process.kill)
            return process

        scheduler = start("scheduler", "--port", "0")
        wait_until(file.exists)

        def worker(**environment: str) -> subprocess.Popen:
            process = start("worker", "--nthreads", "1", "--no-nanny", **environment)
            with Client(json.loads(file.read_text())["address"], set_as_default=False) as client:
                client.wait_for_workers(1)
            return process

        yield scheduler, worker


def wait_until(happened: Callable[[], bool], seconds: float = 120) -> None:
    deadline = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def filling(folder: Path, *options: str) -> subprocess.Popen:
    """A fill on the cluster of a folder, on its way as soon as it says how many workers there are."""
    process = subprocess.Popen(
        [*small_blocks(64), "fill", "--scheduler", "scheduler.json", *options, "--db", "orbits.db"],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    while "worker" not in process.stderr.readline():
        assert process.poll() is None
    return process


def words_stored(path: Path) -> int:
    """How many words are stored."""
    with (
        suppress(sqlite3.OperationalError),
        closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as plain,
    ):
        return plain.execute("SELECT coalesce(sum(words), 0) FROM fill").fetchone()[0]
    return 0


def said_at_the_end(fill: subprocess.Popen) -> str:
    """What a fill said after it was under way: one line."""
    _, said = fill.communicate(timeout=60)
    assert said.count("\n") == 1
    return said


LONG_FILL = ("--p", "12", "--from", "12")  # thousands of blocks


@pytest.mark.slow
def test_a_cluster_from_its_first_worker_to_its_end(tmp_path):
    """Workers that come later, lack orbitdb, or are left by Ctrl-C; at last the scheduler goes."""
    path = tmp_path / "orbits.db"
    (tmp_path / "without").mkdir()
    (tmp_path / "without" / "sitecustomize.py").write_text(WITHOUT_ORBITDB)
    with dask_scheduler(tmp_path) as (scheduler, worker):
        fill = filling(tmp_path, "--p", "7")
        assert fill.poll() is None
        lacking = worker(PYTHONPATH=str(tmp_path / "without"))
        assert f"install orbitdb {__version__} there" in said_at_the_end(fill)
        assert fill.returncode == 1
        lacking.kill()
        lacking.wait()

        fill = filling(tmp_path, "--p", "7")
        assert fill.poll() is None
        worker()
        assert "orbits" in said_at_the_end(fill)
        assert fill.returncode == 0
        stored = words_stored(path)

        fill = filling(tmp_path, *LONG_FILL)
        wait_until(lambda: words_stored(path) > stored)
        fill.send_signal(signal.SIGINT)
        assert "interrupted" in said_at_the_end(fill)
        assert fill.returncode == 130
        half = words_stored(path)

        fill = filling(tmp_path, *LONG_FILL)  # it goes on, on the same cluster
        wait_until(lambda: words_stored(path) > half)
        scheduler.kill()
        assert "connection to the dask scheduler is lost" in said_at_the_end(fill)
        assert fill.returncode == 1
    assert stored < half < words_stored(path) < stored + count_admissible(12)


class Silent(socketserver.BaseRequestHandler):
    """Takes what it is told and never answers."""

    def handle(self) -> None:
        while self.request.recv(1024):
            pass


@pytest.mark.parametrize("listens", [False, True])
@pytest.mark.slow
def test_where_no_scheduler_is(tmp_path, monkeypatch, cli, listens):
    monkeypatch.setattr("orbitdb.filling.cluster.PATIENCE", 0.5)
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
    assert found.code == 2
    assert "pip install 'orbitdb[dask]'" in found.err
