"""The progress line of a command: its text, rate and remaining time."""

import io
import sys
import threading

import pytest

from orbitdb.cli import progress as line
from orbitdb.cli.progress import Pace, clock, frame
from orbitdb.cli.render import note
from orbitdb.filling.resuming import Step, run_steps


def paced(*steps: tuple[float, float], total: float = 1000.0, text: str = "words, p =  9 of 11") -> Pace:
    """Return a pace after steps of (time, amount done)."""
    pace = Pace(text)
    for now, done in steps:
        pace.tell(now, text, done, total)
    return pace


def test_the_line_fits_80_columns():
    pace = paced((0.0, 0.0), (10.0, 250.0))
    assert frame(pace, 10.0, 10.0, 79) == (
        "words, p =  9 of 11  ━━━━━━╾───────────────────   25%   0:30 left  25/s"
    )
    assert frame(pace, 20.0, 20.0, 79).split("  ")[-2].strip() == "0:20 left"  # during a long step
    assert frame(pace, 99.0, 99.0, 79).split("  ")[-2].strip() == "0:01 left"


def test_unknown_totals_and_times_are_left_out():
    assert frame(paced((0.0, 0.0)), 1.0, 1.0, 79).endswith("──    0%  0 of 1,000")
    assert frame(Pace("reading"), 3.0, 3.0, 79) == "reading  0:03"
    done = frame(paced((0.0, 0.0), (10.0, 1000.0)), 12.0, 12.0, 79)
    assert "left" not in done
    assert "━" * 26 + "  100%" in done


def test_a_bar_has_at_least_eight_columns_or_is_left_out():
    pace = paced((0.0, 0.0), (10.0, 250.0))
    widths = {sum(sign in "━╾╸─" for sign in frame(pace, 10.0, 10.0, room)) for room in range(120)}
    assert min(widths - {0}) == 8


def test_too_little_work_gives_no_remaining_time():
    assert paced((0.0, 0.0), (1.0, 9.0)).left(1.0) is None
    assert paced((0.0, 0.0), (1.0, 10.0)).left(1.0) == pytest.approx(99.0)
    assert paced((0.0, 0.0), (10.0, 1.0)).left(10.0) == pytest.approx(9990.0)


def test_a_resumed_fill_shows_its_current_rate():
    """Rows stored before took no time, and the distant past says little about the present rate."""
    assert paced((0.0, 900.0), (10.0, 950.0)).left(10.0) == pytest.approx(10.0)
    slower = paced((0.0, 0.0), (1.0, 500.0), *((2.0 + k, 501.0 + k) for k in range(40)))
    assert slower.rate() == pytest.approx(1.0)


def test_long_steps_have_a_rate_and_a_new_stage_starts_from_zero():
    assert paced((0.0, 0.0), (100.0, 100.0), (200.0, 200.0)).rate() == pytest.approx(1.0)
    for total in (500.0, 1000.0):
        pace = paced((0.0, 0.0), (10.0, 1000.0))
        pace.tell(11.0, "orbits", 10.0, total)
        assert pace.rate() == 0.0


def test_the_line_fits_any_width_without_cutting_numbers():
    whole = "words, p =  9 of 11"
    for room in range(-1, 200):
        shown = frame(paced((0.0, 0.0), (10.0, 250.0)), 10.0, 10.0, room)
        assert len(shown) <= max(room, 0)
        assert shown == whole[: max(room, 0)] or "25%" in shown or room < len(whole) + 6


def test_times_are_easy_to_read():
    told = [clock(seconds) for seconds in (0.4, 61, 3600, 360_000)]
    assert told == ["0:00", "1:01", "1:00:00", "100:00:00"]


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


class Screen(io.TextIOWrapper):
    """A terminal that signals when a bar has been drawn on it."""

    def __init__(self, encoding: str) -> None:
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
        return self.bytes.getvalue().decode(self.encoding)


@pytest.fixture
def screen(monkeypatch):
    """Make stderr a terminal and draw frames without delay."""

    def begin(encoding: str = "utf-8") -> Screen:
        screen = Screen(encoding)
        monkeypatch.setattr(sys, "stderr", screen)
        return screen

    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(line, "PATIENCE", 0.0)
    monkeypatch.setattr(line, "BETWEEN_FRAMES", 0.001)
    return begin


@pytest.mark.parametrize(("encoding", "bar"), [("utf-8", "━━━━━━╾──"), ("ascii", "#######--")])
def test_the_line_makes_room_for_notes_and_is_erased_at_the_end(screen, encoding, bar):
    terminal = screen(encoding)
    with line.progress("windows") as shown:
        shown.tell("windows", 1, 4)
        assert terminal.drawn.wait(60)
        note("an aside")
    text = terminal.shown()
    erase, drawn = "\r\x1b[J", [each for each in text.split("\r") if "25%" in each]
    assert drawn[0].startswith(f"\x1b[Jwindows  {bar}")
    assert f"\r{erase}an aside\n" in text
    assert text.endswith((erase, "an aside\n"))
    note("alone")
    assert terminal.shown() == f"{text}alone\n"


def test_the_line_is_only_drawn_on_a_terminal_and_never_among_rows(screen, monkeypatch):
    def shows(**asked: bool) -> bool:
        with line.progress("rows", **asked) as shown:
            return type(shown) is not line.Progress

    terminal = screen()
    assert (shows(), shows(to_stdout=True)) == (True, True)
    monkeypatch.setattr(sys, "stdout", terminal)
    assert (shows(), shows(to_stdout=True)) == (True, False)
    monkeypatch.setenv("TERM", "dumb")
    assert not shows()
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    monkeypatch.setenv("TERM", "xterm")
    assert not shows()
