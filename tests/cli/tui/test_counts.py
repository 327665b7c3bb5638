"""The screen of counts and histograms, and how counts become lines."""

import pytest
from screens import drive, press, screen_lines, shown

from orbitdb.cli.tui.dialogs.keys import KeysDialog
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.statistics.counts_screen import CountsScreen, lines_of
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection


def test_bars_are_to_scale_and_little_is_seen():
    lines = lines_of([("a", 800), ("bcd", 1), ("", 0)], 20, without=1234)
    assert lines == ["      a   800 ██████", "    bcd     1 ▏", "            0", "without 1,234"]
    assert lines_of([("a", 8), ("b", 3)], 4 + 8) == ["a 8 ████████", "b 3 ███"]
    assert lines_of([("abc", 1234)], 5) == ["abc 1,234"]  # no room for a bar
    assert lines_of([], 20) == ["none"]


@pytest.mark.slow
def test_counts_and_histograms_of_the_subset_on_show(filled_once):
    async def steps(app, pilot):
        await press(pilot, "o", "d")
        assert isinstance(app.screen, CountsScreen)
        text = shown(app)
        count = app.catalogue.count(Selection(statuses=(Status.ORBIT,)))
        assert f"orbit {count:,} █" in text
        assert "length: length of one" in text
        assert "10 " in text
        await press(pilot, "right_square_bracket")
        assert f"orbit {count:,} █" in screen_lines(app)[2][36:]  # status, as a histogram
        await press(pilot, "s", *"jjjjj", "enter", "question_mark")
        assert isinstance(app.screen, KeysDialog)
        assert "histogram of another column" in shown(app)
        await press(pilot, "escape")
        assert app.screen.column == "symmetry"
        assert "xyT " in shown(app)
        await press(pilot, "q")
        assert isinstance(app.screen, MainScreen)

    drive(filled_once, steps)
