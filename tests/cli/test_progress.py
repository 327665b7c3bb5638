"""The progress line of a command: its text, rate and remaining time."""

import io
import os
import re
import sys
import threading

import pytest

from orbitdb import progress as line
from orbitdb.cli.notes import note, progress
from orbitdb.filling.period_jobs import Step, run_steps
from orbitdb.progress import Work, telling

TEXT = "words, p =  9 of 11"


class Screen(io.TextIOWrapper):
    """A terminal that signals when a bar has been drawn on it."""

    def __init__(self, encoding: str = "utf-8", terminal: bool = True) -> None:
        self.bytes = io.BytesIO()
        super().__init__(self.bytes, encoding=encoding, newline="")
        self.drawn, self.terminal = threading.Event(), terminal

    def isatty(self) -> bool:
        return self.terminal

    def write(self, text: str) -> int:
        count = super().write(text)
        if "25%" in text:
            self.drawn.set()
        return count

    def shown(self) -> str:
        self.flush()
        return self.bytes.getvalue().decode(self.encoding)


def reported(*steps: tuple[float, float], total: float = 1000.0, expected: float | None = None) -> Work:
    """Return work after reports of (time, amount done)."""
    work = Work(TEXT, expected, began=0.0)
    for now, done in steps:
        work.report(done, total, TEXT, now)
    return work


def after(*steps: tuple[float, float], total: float = 1000.0, expected: float | None = None) -> str:
    return reported(*steps, total=total, expected=expected).line(79, steps[-1][0])


def test_the_line_fits_80_columns():
    drawn = after((0.0, 0.0), (10.0, 100.0), (20.0, 250.0))
    assert re.fullmatch(rf"{TEXT} ━+─+  25%  0:01:00 left  12/s  250 of 1,000", drawn)
    assert len(drawn) <= 79


@pytest.mark.parametrize(
    ("steps", "expected", "text"),
    [
        ([(0.0, 0.0)], None, "[─]   0%  0 of 1,000$"),
        ([(0.0, 0.0), (10.0, 500.0), (20.0, 1000.0)], None, r"100%  50/s  1,000 of 1,000$"),
        ([(0.0, 0.0), (1.0, 4.0), (2.0, 9.0)], None, "─   0%  4.5/s"),  # too little for a remaining time
        ([(0.0, 0.0), (1.0, 4.0), (2.0, 9.0), (3.0, 10.0)], None, "0:04:57 left"),
        ([(0.0, 900.0), (5.0, 925.0), (10.0, 950.0), (15.0, 970.0)], None, "0:00:06 left"),  # resumed
        ([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)], 40.0, "0:00:39 left"),  # as announced
        ([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (4.0, 500.0)], 40.0, "0:00:04 left"),
    ],
)
def test_the_line_shows_what_can_be_known(steps, expected, text):
    assert re.search(text, after(*steps, expected=expected))
    assert Work("reading", began=0.0).line(79, 3.0) == "reading 0:00:03"


def test_the_remaining_time_runs_down_during_a_long_step():
    work = reported((0.0, 0.0), (10.0, 500.0))
    assert "0:00:10 left" in work.line(79, 10.0)
    assert "0:00:04 left" in work.line(79, 16.0)


def test_a_new_stage_starts_from_zero():
    work = reported((0.0, 0.0), (10.0, 300.0), (20.0, 600.0), total=500.0)
    assert "/s" in work.line(79, 20.0)
    work.report(10.0, 1000.0, TEXT, 21.0)
    assert "/s" not in work.line(79, 21.0)


def test_the_line_fits_any_width_without_cutting_numbers():
    work = reported((0.0, 0.0), (5.0, 100.0), (10.0, 250.0))
    for width in range(1, 200):
        line = work.line(width, 10.0)
        assert len(line) <= width
        assert re.search(r" 25%(  0:00:\d\d left(  25/s(  250 of 1,000)?)?)?$", line) or width < 8


def test_a_fraction_has_no_count():
    assert after((0.0, 0.0), (5.0, 0.1), (10.0, 0.25), total=1.0).endswith("─  25%  0:00:30 left")


def test_a_fill_of_several_periods_has_one_bar():
    """The bar begins with the rows that were stored earlier, also those of later periods."""
    told = []
    steps = (Step(p, words, total, new) for p, words, total, new in ((3, 2, 8, 2), (3, 8, 8, 6)))
    run_steps(
        steps, "words", {2: 1, 3: 8, 5: 96}, lambda done, total, text: told.append((text, done, total)), 97
    )
    assert told == [("words", 97, 105), ("words, p =  3 of 5", 99, 105), ("words, p =  3 of 5", 105, 105)]


@pytest.fixture
def screen(monkeypatch):
    """Make stderr a terminal and draw frames without delay."""

    def begin(encoding: str = "utf-8", terminal: bool = True) -> Screen:
        screen = Screen(encoding, terminal)
        monkeypatch.setattr(sys, "stderr", screen)
        return screen

    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(line, "PATIENCE", 0.0)
    monkeypatch.setattr(line, "BETWEEN_FRAMES", 0.001)
    return begin


@pytest.mark.parametrize(("encoding", "bar"), [("utf-8", "━━━━━━━━━━─"), ("ascii", "==========-")])
def test_the_line_makes_room_for_notes_and_is_erased_at_the_end(screen, encoding, bar):
    terminal = screen(encoding)
    with progress("windows") as shown:
        shown(1, 4, "windows")
        assert terminal.drawn.wait(60)
        note("an aside")
    text = terminal.shown()
    erase, drawn = "\r\x1b[J", [each for each in text.split("\r") if "25%" in each]
    assert drawn[0].startswith(f"\x1b[Jwindows {bar}")
    assert f"\r{erase}an aside\n" in text
    assert text.endswith((erase, "an aside\n"))
    note("alone")
    assert terminal.shown() == f"{text}alone\n"


def test_the_line_is_only_drawn_on_a_terminal_and_never_among_rows(screen, monkeypatch, tmp_path):
    def shows(**asked: bool) -> bool:
        with progress("rows", **asked):
            return line._on_screen is not None

    screen()
    kept, file = os.dup(1), os.open(tmp_path / "rows", os.O_CREAT)
    for stdout, among_rows in ((os.pipe()[1], False), (file, True)):
        os.dup2(stdout, 1)
        shown = (shows(), shows(to_stdout=True))
        os.dup2(kept, 1)
        assert shown == (True, among_rows)
    monkeypatch.setenv("TERM", "dumb")
    assert not shows()
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    monkeypatch.setenv("TERM", "xterm")
    assert not shows()


def test_a_notebook_has_the_same_line_without_terminal_codes(screen, monkeypatch):
    """Neither ipywidgets nor tqdm are needed."""
    notebook = screen(terminal=False)
    monkeypatch.setattr(line, "_in_notebook", lambda: True)
    with telling(None, "fill") as tell:
        tell(1, 4, "words")
        assert notebook.drawn.wait(60)
    text = notebook.shown()
    assert "\x1b" not in text
    assert re.search(r"words ━+─+  25%  1 of 4\r+ +\r$", text)
