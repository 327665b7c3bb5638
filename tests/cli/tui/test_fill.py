"""The fill dialog states the cost of a fill before it begins, and what went wrong."""

import sqlite3
from contextlib import closing
from typing import Any

import pytest
from screens import ask, browsing, press, row_of, settle, shown, table_of, until, write
from textual.widgets import Input

from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui.fill_dialog import FillDialog
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.filling.estimate import need
from orbitdb.selection import Selection


def cost(app):
    return str(app.screen.query_one("#cost").render())


@pytest.mark.slow
async def test_the_dialog_states_the_cost_of_its_fields(filled_once):
    async with browsing(filled_once, selection=Selection(periods=((2, 3),))) as (app, pilot):
        await press(pilot, "f")
        coming = need(filled_once, 1.6, range(2, 10), 1)
        said = f"{coming.words:,} words to fill at a = 1.6: under a second, up to "
        assert cost(app) == f"{said}{coming.bytes / 1e3:.0f} kB"
        assert cost(app) in shown(app)
        await write(pilot, "2-8", field="#periods")
        assert ": nothing to do" in cost(app)
        await press(pilot, "enter")
        assert app.fill_state is None
        await write(pilot, "1^20 3, 0132", field="#codes")
        assert cost(app) == "2 words to solve at a = 1.6"
        assert app.screen.query_one("#periods").disabled  # they would have no effect
        await write(pilot, "139", field="#codes")
        assert "symbol '9'" in cost(app)


@pytest.mark.slow
async def test_the_first_key_goes_into_the_field_of_periods(tmp_path):
    """If another field had focus for a moment, a fast typist would fill a different stadium."""
    focused = []

    class Watched(FillDialog):
        def on_descendant_focus(self, event):
            focused.append(event.widget.id)

    async with browsing(tmp_path / "new.db") as (app, pilot):
        app.push_screen(Watched(app.catalogue.path, Selection(), ()))
        await settle(pilot)
        await press(pilot, *"23")
        assert app.screen.query_one("#periods", Input).value == "23"
    assert focused == ["periods"]


@pytest.mark.slow
async def test_failures_are_reported_and_the_screen_keeps_working(filled, tmp_path, monkeypatch):
    """The failures are an export into a missing folder, and a fill while another process holds the lock."""
    monkeypatch.setattr("orbitdb.store.sqlite.BUSY_TIMEOUT", 0.1)
    nowhere = tmp_path / "none" / "rows.csv"

    with closing(sqlite3.connect(filled, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        async with browsing(filled) as (app, pilot):
            rows = len(table_of(app).source)
            await pilot.press("e")
            await write(pilot, str(nowhere))
            assert "the chosen rows, in full precision" in shown(app)
            await write(pilot, "rows.gif")
            assert "rows.gif: end the name in .csv, " in shown(app)
            await write(pilot, str(nowhere), "enter")
            assert isinstance(app.screen, MainScreen)
            await press(pilot, "f")
            app.screen.query_one("#a", Input).value = "1"
            await write(pilot, "2-3", "enter", field="#periods")
            assert app.fill_state.state == "failed"
            assert "another process that writes" in app.fill_state.sentence()
            await press(pilot, "escape")
            told = [(note.severity, note.message) for note in app._notifications]
            assert any(severity == "error" and str(nowhere.parent) in message for severity, message in told)
            assert ("error", f"fill {app.fill_state.sentence()}") in told
            assert len(table_of(app).source) == rows
        other.execute("ROLLBACK")
    assert [*Catalogue(filled).fills(a=1.0)] == []


@pytest.mark.slow
async def test_filling_an_empty_catalogue_gives_the_shown_orbit_its_row(tmp_path):
    async with browsing(tmp_path / "new.db") as (app, pilot):
        assert "fill the catalogue" in shown(app)
        for key, told in (("d", "press f to"), ("S", "press f to"), ("v", "press c and type a code")):
            app.clear_notifications()
            await press(pilot, key)
            [note] = app._notifications
            assert told in note.message
        await press(pilot, "y")  # there is no word to copy yet
        assert app.clipboard == ""
        app.clear_notifications()
        await ask(pilot, "c", "1232131")
        await press(pilot, "ctrl+r")
        assert "fill the catalogue" not in shown(app)
        assert "1232131 is not stored" in shown(app)
        await press(pilot, "f", *"2-7", "enter")
        await until(lambda: app.fill_state is not None and not app.fill_state.runs)
        assert app.fill_state.sentence() == "done: 1,101 words"
        await settle(pilot)
        assert isinstance(app.screen, MainScreen)  # the dialog closes by itself
        assert app._notifications
        assert [*app._notifications][-1].message == "fill done: 1,101 words"
        await press(pilot, "f")
        assert "done" not in shown(app)
        await write(pilot, "2-8", field="#periods")
        assert "2,096 words to fill" in cost(app)
        await press(pilot, "enter")
        await until(lambda: app.fill_state.request.periods[-1] == 8 and not app.fill_state.runs)
        assert app.fill_state.sentence() == "done: 2,096 words"  # as many as it promised
        await settle(pilot)
        main: Any = app.screen
        assert len(table_of(app).source) == app.catalogue.count(Selection()) > 1101
        assert (main.side.orbit.code, main.side.orbit.stored) == ("1232131", True)
        assert row_of(app)[0] == "1123213"
        assert "not stored" not in shown(app)
        await press(pilot, "j", "k")
        assert main.side.orbit.code == "1123213"


@pytest.mark.slow
async def test_a_period_amid_others_is_filled_with_the_words_that_were_promised(filled):
    Catalogue(filled).delete(1.6, 5)
    async with browsing(filled) as (app, pilot):
        await press(pilot, "f")
        await write(pilot, "2-8", field="#periods")
        assert "96 words to fill" in cost(app)
        await press(pilot, "enter")
        await until(lambda: app.fill_state is not None and not app.fill_state.runs)
        assert app.fill_state.sentence() == "done: 96 words"
