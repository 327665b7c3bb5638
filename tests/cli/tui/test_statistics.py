"""The screens of statistics, counts and histograms."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from contents import alter
from rich.console import Console
from screens import LARGE, browsing, press, screen_lines, settle, shown, table_of
from there import there

from orbitdb.averages.by_period import Weight
from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui import counts_screen
from orbitdb.cli.tui import statistics_screen as statistics
from orbitdb.cli.tui.counts_screen import DRAWN, Count, CountsScreen
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.store.sqlite import never
from orbitdb.store.storing import keep_reference
from orbitdb.store.writer import Writer
from orbitdb.symbols.pruning import count_admissible, count_primitive
from orbitdb.text import with_error
from orbitdb.trajectories.ensemble import Reference


def test_only_averages_of_the_first_periods_are_computed_unasked(filled_once, monkeypatch):
    monkeypatch.setattr(statistics, "FIRST", 4)
    for periods, first, rest, every in (
        ((), [2, 3, 4], "periods 5-8: press m", [2, 3, 4, 5, 6, 7, 8]),
        (((4, 6),), [4], "periods 5-6: press m", [4, 5, 6]),
        (((5, 6),), None, "periods 5-6: press m", [5, 6]),
        (((3, 4),), [3, 4], "", [3, 4]),
    ):
        screen = statistics.StatisticsScreen(Catalogue(filled_once), Selection(periods=periods))
        found, note = screen.averages(Weight.EXPONENTIAL)
        assert (found and found["p"], note) == (first, rest)
        found, note = screen.averages(Weight.EXPONENTIAL, everything=True)
        assert (there(found)["p"], note) == (every, "")


async def test_a_subset_without_averages_says_why_and_draws_nothing(filled_once):
    async with browsing(filled_once, selection=Selection(where="length < 1")) as (app, pilot):
        await press(pilot, "S")
        assert "no orbits at a = 1.6 where length < 1 " in shown(app)
        assert not any(plot.region for plot in app.screen.query("Plot"))


@pytest.mark.slow
async def test_new_trajectories_replace_stored_ones(filled, monkeypatch):
    monkeypatch.setattr(statistics, "FIRST_BOUNCES", 100_000)
    stored = Reference(1.6, 0.8867, 0.5, 0.3752, 0.5, 2.3, 0.1, 10**9, 16, 5)
    writer = Writer(filled, {"command": "test"})
    keep_reference(writer, stored)
    writer.close()
    async with browsing(filled, LARGE, Selection(periods=((2, 3),))) as (app, pilot):
        await press(pilot, "S")
        assert app.screen.reference == stored
        text = " ".join(shown(app).split())
        assert f"lambda_d {with_error(0.8867, 0.5).replace('+-', '±')}" in text
        assert "; stored" in text
        await press(pilot, "t")
        assert "bounces, computed now" in shown(app)
        assert app.screen.reference.lambda_d_error < 0.1
        assert app.screen.reference.lambda_d == pytest.approx(0.8868, abs=0.05)


def lines_of(counts, width):
    console = Console(width=width)
    with console.capture() as captured:
        console.print(*counts_screen.lines_of([Count(label, count, "") for label, count in counts]), sep="")
    return [line.rstrip() for line in captured.get().splitlines()]


def test_bars_are_to_scale_and_small_counts_are_visible():
    lines = lines_of([("a", 800), ("bcd", 1), ("", 0), ("without", 1234)], 28)
    assert lines == ["      a   800 ██████████████", "    bcd     1 ▏", "            0", "without 1,234"]
    assert lines_of([("a", 8), ("b", 3)], 4 + 8) == ["a 8 ████████", "b 3 ███"]
    assert lines_of([("abc", 1234)], 11) == ["abc 1,234 █"]  # the minimum width


def test_every_count_has_a_condition_that_chooses_its_rows(varied):
    chosen, catalogue = Selection(periods=((2, 6),)), Catalogue(varied)
    screen = CountsScreen(catalogue, chosen, "length")
    groups, _ = screen._count(never)
    columns = ("length", "margin", "residual", "maslov", "rules")
    every = [*groups.values(), *(screen._values(column, 8, never)[0] for column in columns)]
    assert {sum(count.rows for count in group) for group in every} == {catalogue.count(chosen)}
    counts = [count for group in every for count in group]
    assert len(counts) > 40
    for count in counts:
        assert catalogue.count(replace(chosen, where=count.condition)) == count.rows, count


def test_a_value_an_ulp_outside_the_rounded_edges_is_counted(varied, tmp_path):
    path = Path(shutil.copy(varied, tmp_path / "orbits.db"))
    alter(
        path,
        "UPDATE orbit SET length = 0.0031829 WHERE length IS NOT NULL",
        "UPDATE orbit SET length = 0.0031249999999999997 WHERE cycle = (SELECT min(cycle) FROM orbit)",
    )
    counts, _ = CountsScreen(Catalogue(path), Selection(), "length")._values("length", 20, never)
    assert counts[0].rows == Catalogue(path).count(where=counts[0].condition) > 0


@pytest.mark.slow
async def test_the_shown_subset_has_counts_and_histograms(filled_once, varied):
    some = Selection(periods=((3, 3),), statuses=(Status.ORBIT, Status.GEOMETRIC))
    async with browsing(varied, selection=some) as (app, pilot):
        await press(pilot, "d")
        pruned = count_primitive(3) - count_admissible(3)
        assert shown(app).count(f"without {pruned} ") == 3  # for symmetry, reversal and length
    async with browsing(filled_once) as (app, pilot):
        await press(pilot, "o", "d")
        assert isinstance(app.screen, CountsScreen)
        text = shown(app)
        count = app.catalogue.count(Selection(statuses=(Status.ORBIT,)))
        assert f"orbit {count:,} █" in text
        assert "length: length of one" in text
        assert re.search(r"\b10–(\d+) +[\d,]+ .*\n.*\b\1–", text)  # each bin begins where the one before ends
        await press(pilot, "right_square_bracket")
        assert any(f"orbit {count:,} █" in line[36:] for line in screen_lines(app))  # the histogram of status
        await press(pilot, "s", *"jjjjj", "enter")
        assert app.screen.column == "symmetry"
        assert "xyT " in shown(app)
        app.screen.column = DRAWN[-1]
        await press(pilot, "right_square_bracket")
        assert app.screen.column == DRAWN[0]
        await press(pilot, "q")
        assert isinstance(app.screen, MainScreen)
        await press(pilot, "d", "tab", "end", "enter")  # the longest orbits
        where = app.screen.choices.selection.where
        assert there(where).startswith("length >= ")
        assert len(table_of(app).source) == app.catalogue.count(status="orbit", where=where) > 0
        await press(pilot, "u")
        assert app.screen.choices.selection == Selection(statuses=(Status.ORBIT,))
        app.screen.rows.columns = ("code", "maslov", "cycle")
        await settle(pilot)
        for column, drawn in (("maslov", "maslov"), ("cycle", "length")):  # under the cursor, if drawable
            await press(pilot, "l")
            assert table_of(app).current == column
            await press(pilot, "d")
            assert app.screen.column == drawn
            await press(pilot, "q")
