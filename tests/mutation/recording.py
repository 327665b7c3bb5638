"""A pytest plugin: every line that is executed is told which test, or which shared fixture, it serves."""

import functools
import json
import os
import sys
from pathlib import Path

import coverage
import pytest

TARGET = "ORBITDB_RECORD_TO"
_PACKAGE = "ORBITDB_RECORD_OF"
_now = ""


def _switch(label: str) -> str:
    """Name what is done from here on; return what was before."""
    global _now
    before, _now = _now, label
    current = coverage.Coverage.current()
    if current is not None:
        current.switch_context(label)
    return before


def _forget() -> None:
    """Empty the caches of the package: what one test has computed, the next one executes, too."""
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == os.environ[_PACKAGE]:
            for value in vars(module).values():
                if isinstance(value, functools._lru_cache_wrapper):
                    value.cache_clear()


def _shared(item: pytest.Item) -> list[str]:
    """Return the fixtures of a test that it shares with others."""
    known = getattr(item, "_fixtureinfo", None)
    defined = [each[-1] for each in known.name2fixturedefs.values()] if known else []
    return [_label(each) for each in defined if each.scope != "function"]


def _label(fixture) -> str:
    return f"fixture {fixture.baseid} {fixture.argname}"


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item):
    item.user_properties.append(("shared", _shared(item)))
    _forget()
    _switch(item.nodeid)
    try:
        return (yield)
    finally:
        _switch("")


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_fixture_setup(fixturedef, request):
    if fixturedef.scope == "function":
        return (yield)
    before = _switch(_label(fixturedef))
    try:
        return (yield)
    finally:
        _switch(before)


class _Record:
    def __init__(self) -> None:
        self.tests: dict[str, dict] = {}

    def pytest_runtest_logreport(self, report) -> None:
        told = self.tests.setdefault(report.nodeid, {"seconds": 0.0, "passed": True, "shared": []})
        told["seconds"] += report.duration
        told["passed"] &= report.passed
        told["shared"] = dict(report.user_properties).get("shared", [])

    def pytest_sessionfinish(self) -> None:
        Path(os.environ[TARGET]).write_text(json.dumps(self.tests))


def pytest_configure(config) -> None:
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(_Record())
