"""The terminal UI in real terminals of any size, and of little ability."""

import pexpect
import pytest
from terminal import ended, spawn

HABITS = [
    pytest.param((1, 1), {}, id="1x1", marks=pytest.mark.fuzz),
    pytest.param((20, 8), {"TERM": "dumb", "LC_ALL": "C"}, id="dumb"),
    pytest.param((160, 48), {"TERM": ""}, id="no TERM", marks=pytest.mark.fuzz),
]


@pytest.mark.slow
@pytest.mark.parametrize(("size", "variables"), HABITS)
def test_it_opens_its_screens_and_leaves(filled_once, size, variables):
    columns, rows = size
    child = spawn("browse", "--db", filled_once, columns=columns, rows=rows, **variables)
    raw = _until_quiet(child)
    for key in ("/", "\x1b", "f", "\x1b", "S", "\x1b", "?", "\x1b"):
        child.send(key)
        raw += _until_quiet(child)
    child.send("q")
    child.expect(pexpect.EOF)
    session = ended(child, (raw + child.before, columns))
    assert session.code == 0
    assert "Traceback" not in session.text
    assert session.restored
    assert "\x1b[?1049l" in session.raw  # what was on the terminal before is there again


def _until_quiet(child):
    """Return what is written until nothing comes for a while."""
    raw = ""
    while child.expect([".+", pexpect.TIMEOUT], timeout=0.25 if raw else 30) == 0:
        raw += child.after
    return raw
