"""A pytest plugin that records which tests and shared fixtures execute each line.

Threads are followed. Child processes are not, because other tests run the same code directly.
"""

import functools
import json
import os
import sys
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest
from coverage import Coverage

FOLDER = "ORBITDB_RECORD_TO"


class Recorder:
    """What a pytest process executes, by test, and the time of each test."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / f"{os.getpid()}.json"
        tops = [str(folder.parent / "tree" / top) for top in ("orbitdb", "cli", "migrations")]
        self.coverage = Coverage(data_file=None, config_file=False, source=tops)
        self.tests: dict[str, Any] = {}
        self.now = ""

    def switch(self, label: str) -> str:
        """Set the label of what is executed from here on; return the old one."""
        before, self.now = self.now, label
        self.coverage.switch_context(label)
        return before

    def pytest_sessionstart(self) -> None:
        self.coverage.start()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        known = getattr(item, "_fixtureinfo", None)
        defined = [each[-1] for each in known.name2fixturedefs.values()] if known else []
        shared = [_label(each) for each in defined if each.scope != "function"]
        self.tests[item.nodeid] = {"seconds": 0.0, "shared": shared}
        _forget()
        self.switch(item.nodeid)
        try:
            return (yield)
        finally:
            self.switch("")

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_fixture_setup(self, fixturedef: pytest.FixtureDef[Any]) -> Generator[None, object, object]:
        before = self.switch(_label(fixturedef) if fixturedef.scope != "function" else self.now)
        try:
            return (yield)
        finally:
            self.switch(before)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.nodeid in self.tests:
            self.tests[report.nodeid]["seconds"] += report.duration

    def pytest_sessionfinish(self) -> None:
        self.coverage.stop()
        data = self.coverage.get_data()
        lines = {file: data.contexts_by_lineno(file) for file in data.measured_files()}
        self.path.write_text(json.dumps({"tests": self.tests, "lines": lines}))


def _label(fixture: pytest.FixtureDef[Any]) -> str:
    return f"fixture {fixture.baseid} {fixture.argname}"


def _forget() -> None:
    """Empty the caches of the package, so that each test executes everything it needs."""
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == "orbitdb":
            for value in vars(module).values():
                if isinstance(value, functools._lru_cache_wrapper):
                    value.cache_clear()


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Recorder(Path(os.environ[FOLDER])))
