"""The progress line of a command: its text, rate and remaining time."""

import io
import re
import sys
import threading
from functools import partial

import pytest
from rich.progress import Progress

from orbitdb.cli import progress as line
from orbitdb.cli.progress import bars_on, frame
from orbitdb.cli.render import note
from orbitdb.filling.resuming import Step, run_steps

TEXT = "words, p =  9 of 11"


class Screen(io.TextIOWrapper):
    """A terminal that signals when a bar has been drawn on it."""

    def __init__(self, encoding: str = "utf-8") -> None:
        self.bytes = io.BytesIO()
        super().__init__(self.bytes, encoding=encoding, newline="")
        self.drawn = threading.Event()

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        count = super().write(text)
        if "25%" in text:
            self.drawn.set()
        return count

    def shown(self) -> str:
        self.flush()
        return without_colours(self.bytes.getvalue().decode(self.encoding))


def without_colours(text: str) -> str:
    return re.sub(r"\x1b\[[\d;]*m", "", text)


@pytest.fixture
def bars(monkeypatch) -> Progress:
    """Return bars on a terminal of 80 columns, with a clock to set."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    return bars_on(Screen())


def after(bars: Progress, *steps: tuple[float, float], total: float = 1000.0, expected: float | None = None):
    """Return the line after steps of (time, amount done)."""
    for now, done in steps:
        bars.get_time = partial(float, now)
        drawn = without_colours(frame(bars, done, total, TEXT, now, expected))
    return drawn


def test_the_line_fits_80_columns(bars):
    drawn = after(bars, (0.0, 0.0), (10.0, 100.0), (20.0, 250.0))
    assert re.fullmatch(rf"{TEXT} ━+[╸╺]?━+  25%  0:00:50 left  15/s  250 of 1,000", drawn)
    assert len(drawn) == 79


def test_unknown_totals_and_times_are_left_out(bars):
    assert after(bars, (0.0, 0.0)).endswith("━   0%  0 of 1,000")
    assert re.fullmatch("reading ━{40} 0:00:03", without_colours(frame(bars, 0.0, 0.0, "reading", 3.0)))
    done = after(bars, (0.0, 0.0), (10.0, 500.0), (20.0, 1000.0))
    assert "left" not in done
    assert "100%" in done


def test_too_little_work_gives_no_remaining_time(bars):
    assert "left" not in after(bars, (0.0, 0.0), (1.0, 4.0), (2.0, 9.0))
    assert "0:05:30 left" in after(bars, (3.0, 10.0))


def test_a_resumed_fill_shows_its_current_rate(bars):
    """Rows stored before took no time."""
    assert "0:00:07 left" in after(bars, (0.0, 900.0), (5.0, 925.0), (10.0, 950.0), (15.0, 970.0))


def test_a_new_stage_starts_from_zero(bars):
    for total in (500.0, 1000.0):
        assert "/s" in after(bars, (0.0, 0.0), (10.0, 300.0), (20.0, 600.0))
        assert "/s" not in after(bars, (21.0, 10.0), total=total)


def test_the_bar_starts_from_the_announced_time(bars):
    steps = ((0.0, 0.0), (1.0, 1.0), (2.0, 2.0))
    assert "0:00:39 left" in after(bars, *steps, expected=40.0)
    assert "0:00:04 left" in after(bars, (4.0, 500.0), expected=40.0)


def test_the_line_fits_any_width_without_cutting_numbers(bars):
    for columns in range(1, 200):
        bars.console.width = columns
        shown = after(bars, (0.0, 0.0), (5.0, 100.0), (10.0, 250.0))
        assert len(shown) <= max(columns - 1, 1)
        assert "\n" not in shown
        assert re.search(r"25%(  0:00:\d\d left(  30/s(  250 of 1,000)?)?)?$", shown) or columns < 8


def test_a_fraction_has_no_count(bars):
    assert after(bars, (0.0, 0.0), (5.0, 0.1), (10.0, 0.25), total=1.0).endswith("━  25%  0:00:25 left")


def test_a_fill_of_several_periods_has_one_bar():
    """Rows stored earlier count for their period, whether they were filled now or not."""
    told = []
    steps = (Step(p, words, total) for p, words, total in ((3, 2, 8), (3, 8, 8), (5, 96, 96)))
    run_steps(
        steps, "words", {2: 1, 3: 8, 5: 96}, lambda done, total, text: told.append((text, done, total)), 1
    )
    assert told == [
        ("words", 1, 105),
        ("words, p =  3 of 5", 3, 105),
        ("words, p =  3 of 5", 9, 105),
        ("words, p =  5 of 5", 105, 105),
    ]


@pytest.fixture
def screen(monkeypatch):
    """Make stderr a terminal and draw frames without delay."""

    def begin(encoding: str = "utf-8") -> Screen:
        screen = Screen(encoding)
        monkeypatch.setattr(sys, "stderr", screen)
        return screen

    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(line, "PATIENCE", 0.0)
    monkeypatch.setattr(line, "BETWEEN_FRAMES", 0.001)
    return begin


@pytest.mark.parametrize(("encoding", "bar"), [("utf-8", "━━━━━━━━━━╺━━"), ("ascii", "---------- ---")])
def test_the_line_makes_room_for_notes_and_is_erased_at_the_end(screen, encoding, bar):
    terminal = screen(encoding)
    with line.progress("windows") as shown:
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


def test_the_line_is_only_drawn_on_a_terminal_and_never_among_rows(screen, monkeypatch):
    def shows(**asked: bool) -> bool:
        with line.progress("rows", **asked):
            return line._on_screen is not None

    terminal = screen()
    assert (shows(), shows(to_stdout=True)) == (True, True)
    monkeypatch.setattr(sys, "stdout", terminal)
    assert (shows(), shows(to_stdout=True)) == (True, False)
    monkeypatch.setenv("TERM", "dumb")
    assert not shows()
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    monkeypatch.setenv("TERM", "xterm")
    assert not shows()
