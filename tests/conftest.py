"""Fixtures that several test modules share: filled catalogues and the command line."""

import asyncio
import gc
import inspect
import os
import shutil
import signal
import sqlite3
from collections.abc import Callable, Generator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest
from hypothesis import settings

if TYPE_CHECKING:  # pytest's controller process need not import these
    import numpy as np
    from numpy.typing import NDArray

    from orbitdb.filling.period_jobs import Step

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # for child processes, as in `orbitdb.cli.main`
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # children share compiled imports
settings.register_profile("quick", deadline=None, max_examples=10)
settings.register_profile("thorough", deadline=None, max_examples=60)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "quick"))


def pytest_configure() -> None:
    """Let signals end child processes even if a shell made this process ignore them, as ``&`` does."""
    for name in ("SIGINT", "SIGHUP", "SIGTERM"):
        number = getattr(signal, name, None)
        if number and signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, lambda number, frame: None)  # handlers are not inherited


def pytest_collection() -> None:
    """Disable garbage collection during imports, which saves a fifteenth of the time."""
    gc.disable()


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.set_threshold(50_000)  # the default of 700 objects costs a thirtieth of the time
    gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> None:
    """Allow tests to be coroutines."""
    if inspect.iscoroutinefunction(test := pyfuncitem.obj):
        pyfuncitem.obj = lambda **given: asyncio.run(test(**given))


@pytest.fixture(scope="session", autouse=True)
def own_state(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep the tests apart from the developer's own catalogue, and own choices in `browse`."""
    os.environ.pop("ORBITDB_DB", None)
    for kind in ("DATA", "STATE"):
        os.environ[f"XDG_{kind}_HOME"] = str(tmp_path_factory.mktemp(kind.lower()))


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut periods into many blocks, so that a fill can be stopped between them."""
    from orbitdb.filling.fill import METHODS, Method
    from orbitdb.orbits.solve import solve

    monkeypatch.setitem(METHODS, "newton", Method(solve, 32))


@pytest.fixture
def small_sweeps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut periods into many blocks and start workers even for small sweeps."""
    monkeypatch.setattr("orbitdb.filling.sweeps.CLASSES", 8)
    monkeypatch.setattr("orbitdb.filling.sweeps.SMALL", 1)


class Outcome(NamedTuple):
    code: int
    out: str
    err: str

    def says(self, code: int, *pieces: str) -> bool:
        """Tell whether the command exited with `code`, and with one line that has all pieces, but no data."""
        one = self.err.count("\n") == 1
        return (self.code, self.out, one) == (code, "", True) and all(each in self.err for each in pieces)


@pytest.fixture(scope="session")
def made_once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[Path], object]], Path]:
    """Return a function that makes a catalogue once for all processes of a run, which read or copy it."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent

    def once(name: str, make: Callable[[Path], object]) -> Path:
        draft, done = folder / f"{name}-draft", folder / name
        with closing(sqlite3.connect(folder / f"{name}-lock", timeout=500, isolation_level=None)) as lock:
            lock.execute("BEGIN EXCLUSIVE")
            if not done.exists():
                draft.mkdir()
                make(draft / "orbits.db")
                draft.rename(done)
        return done / "orbits.db"

    return once


@pytest.fixture(scope="session")
def filled_once(made_once: Callable[..., Path]) -> Path:
    from contents import made

    from orbitdb.filling.fill import fill_periods

    return made_once("filled", lambda path: made(path, fill_periods(path, 1.6, range(2, 9))))


@pytest.fixture
def filled(filled_once: Path, tmp_path: Path) -> Path:
    """A copy of a catalogue with p = 2..8 at a = 1.6."""
    return Path(shutil.copy(filled_once, tmp_path / "orbits.db"))


@pytest.fixture
def begin_fill(small_blocks: None) -> Callable[..., Generator["Step"]]:
    """Start to fill a period in small blocks; return the remainder of the fill, which close() stops."""
    from orbitdb.filling.fill import fill_periods

    def begin(path: Path, p: int, batches: int = 3, a: float = 1.6) -> Generator["Step"]:
        going = fill_periods(path, a, [p])
        full = (step for step in going if step.words)  # a block of high first symbols may be empty
        for _ in range(batches):
            step = next(full)
        assert step.words < step.total
        return going

    return begin


@pytest.fixture
def cli(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> Callable[..., Outcome]:
    """Run the command line in this process; the default catalogue is in the test's folder."""
    from orbitdb.cli.main import execute

    monkeypatch.setenv("ORBITDB_DB", str(tmp_path / "orbits.db"))

    def run(*arguments: str) -> Outcome:
        capsys.readouterr()
        code = execute(list(arguments))
        captured = capsys.readouterr()
        return Outcome(code, captured.out, captured.err)

    return run


@pytest.fixture(scope="session")
def varied(made_once: Callable[..., Path]) -> Path:
    """A catalogue of p = 2..6 at a = 1.6 and 1, one word of p = 12, and the words pruned at p = 3."""
    from contents import made

    from orbitdb.filling.fill import fill_geometric, fill_periods, fill_words

    def make(path: Path) -> None:
        made(path, *(fill_periods(path, a, range(2, 7)) for a in (1.6, 1.0)), fill_geometric(path, [3]))
        fill_words(path, ["013311133313"], 1.6)

    return made_once("varied", make)


@pytest.fixture(scope="session")
def born_once(made_once: Callable[..., Path]) -> Path:
    """A catalogue with the births of p = 2..6 and nothing else."""
    from contents import made

    from orbitdb.filling.fill import fill_births

    return made_once("born", lambda path: made(path, fill_births(path, range(2, 7))))


@pytest.fixture(scope="session")
def exact_once(made_once: Callable[..., Path]) -> "NDArray[np.float64]":
    """All levels of parity oo below k = 16 at a = 1.6."""
    import numpy as np

    from orbitdb.quantum.exact_levels import levels

    return np.loadtxt(made_once("exact", lambda path: np.savetxt(path, levels(1.6, 16.0, parity=["oo"]).k)))


@pytest.fixture(scope="session")
def awkward_once(made_once: Callable[..., Path]) -> Path:
    """The catalogue that schema 9 left, with more of what is rarely stored; see `awkward`."""
    from contents import awkward

    return made_once("awkward", awkward)


@pytest.fixture
def awkward(awkward_once: Path, tmp_path: Path) -> Path:
    """A copy of the catalogue with the awkward cases (`contents.awkward`), the command line's default."""
    return Path(shutil.copy(awkward_once, tmp_path / "orbits.db"))


@pytest.fixture
def own(varied: Path, tmp_path: Path) -> Path:
    """A copy of the varied catalogue, the default of the command line."""
    return Path(shutil.copy(varied, tmp_path / "orbits.db"))
