"""The screen in real terminals: bursts of keys, failures and signals."""

import io
import os
import random
import shutil
import signal
import sys
from contextlib import suppress

import pexpect
import pytest
from quick import fuzz_but
from terminal import ended, spawn

pytestmark = pytest.mark.slow

DIALOGS = ["s", "a", "E", "e", "/", "c", "C", "O", "f", "?", "S", "d", "ds", "\r", *["\x10"] * 4]
"""Keys that open a dialog or a screen; ctrl+p is tried in all four ways."""

KEYS = [
    *"sSaEe/cCOf?dv=urRoTXYjkhlgGJKxwtn <>,.[]*'",
    *("\r", "\r", "\r", "\x1b", "\x1b", "\t", "\x7f", "\x1b[A", "\x1b[B", "\x1b[6~", "\x10", "\x12"),
]


def quiet(child, patience=0.3):
    """Read what is drawn until nothing more arrives for a while, or until the output ends.

    A moving particle is drawn again and again.
    """
    drawn = ""
    for _ in range(1000):
        if child.expect([".+", pexpect.TIMEOUT, pexpect.EOF], timeout=patience):
            break
        drawn += child.after
    return drawn


@pytest.fixture(autouse=True)
def own_state(tmp_path, monkeypatch):
    """Begin each session with the usual columns and order, not with those that random keys have chosen."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))


@pytest.fixture
def browse(filled_once, tmp_path, monkeypatch):
    """Return a session on a copy of a catalogue, in its own folder, after its first rows are drawn."""
    monkeypatch.chdir(tmp_path)
    path = shutil.copy(filled_once, tmp_path / "orbits.db")
    sessions = []

    def begin(*arguments, **variables):
        child = spawn("browse", "--db", path, *arguments, columns=120, rows=40, **variables)
        child.logfile_read = io.StringIO()
        sessions.append(child)
        child.expect("1 of [0-9,]+|is not stored")
        quiet(child)
        return child

    yield begin
    for child in sessions:
        with suppress(OSError):  # it may already be closed
            child.close(force=True)


def lives(child):
    """Check that a session is alive and ends cleanly on SIGTERM."""
    child.kill(signal.SIGTERM)
    child.expect(pexpect.EOF)
    session = ended(child, (child.before, 120))
    assert (session.code, "Traceback" in session.text) == (143, False), session.text


def test_every_dialog_survives_two_keys_at_once(browse):
    """Enter twice, or enter and escape, before and after the dialog has opened."""
    child = browse()
    for number, dialog in enumerate(DIALOGS):
        soon, keys = number % 2 == 0, ("\r\r", "\r\x1b")[number // 2 % 2]
        child.send(dialog + (keys if soon else ""))
        quiet(child, 0.1)
        if not soon:
            child.send(keys)
            quiet(child, 0.1)
        for _ in range(3):
            child.send("\x1b")
            quiet(child, 0.05)
        assert child.isalive(), (dialog, keys)
    lives(child)


@pytest.mark.parametrize("seed", fuzz_but([1], range(1, 9)))
def test_forty_keys_at_once_do_no_harm(browse, seed):
    child = browse()
    chosen = random.Random(seed).choices(KEYS, k=40)
    child.send("".join(chosen[:20]))
    quiet(child, 0.15)
    for key in chosen[20:]:
        child.send(key)
    quiet(child)
    assert child.isalive(), chosen
    lives(child)


def test_keys_sent_at_once_edit_a_line_in_order(browse):
    """A code is mistyped, corrected and entered in a single write, as in a paste or on a slow line."""
    child = browse("--code", "13")
    child.send("c99\x7f\x7f0231\x1b[D\x7f3\r")
    child.expect("4 words, least 0132, symmetry xyT")
    lives(child)


_FAILING = """
from orbitdb.cli.tui.panels.rows_panel import RowsPanel
RowsPanel.action_sort = lambda self, falling: 1 / 0
from orbitdb.cli.main import run
run()
"""


def test_a_failure_restores_the_terminal_and_shows_the_traceback(filled_once):
    command = [sys.executable, "-P", "-c", _FAILING]
    child = spawn("browse", "--db", filled_once, command=command, columns=200)
    child.expect("1 of [0-9,]+|is not stored")
    shown = child.before
    child.send("R")
    child.expect(pexpect.EOF)
    session = ended(child, (shown + child.before, 200))
    assert session.code == 1
    assert session.restored
    assert session.lines[-1] == "ZeroDivisionError: division by zero"


_READING = """
import time
from orbitdb.cli.tui.panels.rows_panel import RowsPanel
read = lambda cancelled: time.sleep(600)
RowsPanel.action_sort = lambda self, falling: self.app.in_thread("long", read, print)
from orbitdb.cli.main import run
run()
"""


def test_a_screen_does_not_wait_for_a_thread_that_still_reads(filled_once):
    child = spawn("browse", "--db", filled_once, command=[sys.executable, "-P", "-c", _READING])
    child.expect(" 1 of [0-9,]+|is not stored")
    shown = child.before
    child.send("Rq")
    child.expect(pexpect.EOF, timeout=60)
    session = ended(child, (shown + child.before, 80))
    assert (session.code, session.restored) == (0, True)


@pytest.mark.parametrize(
    ("how", "code"), [(signal.SIGTERM, 143), ("closed", 129), (signal.SIGHUP, 129), ("stopped", 143)]
)
def test_a_busy_screen_ends_at_once(browse, how, code):
    """It ends even if the terminal is gone, or no longer reads what is written."""
    child = browse("--code", "0102020203")
    child.send(">>>jjj>j>")
    if how == "closed":
        os.close(child.child_fd)
    elif how == "stopped":
        child.send("j>" * 200)  # nobody reads the output
        child.kill(signal.SIGTERM)
    else:
        child.kill(how)
        child.expect(pexpect.EOF)
    process = child.ptyproc
    if process.exitstatus is None:
        process.wait()
    assert (process.exitstatus, process.signalstatus) == (code, None)


def test_a_dumb_terminal_is_restored(browse):
    child = browse(TERM="dumb", LC_ALL="C")
    for key in ("/", "\x1b", "f", "\x1b", "S", "\x1b", "?", "\x1b"):
        child.send(key)
        quiet(child)
    child.send("q")
    child.expect(pexpect.EOF)
    session = ended(child, (child.logfile_read.getvalue(), 120))
    assert (session.code, "Traceback" in session.text) == (0, False)
    assert session.restored
