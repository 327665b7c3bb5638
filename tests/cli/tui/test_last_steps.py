"""What a key or a dialog changes is there afterwards: in the rows, in the state file and in the catalogue."""

import json

import pytest
from screens import browsing, press, table_of, until

from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui.fill_dialog import FillRequest, FillState
from orbitdb.cli.tui.stored import Ordering
from orbitdb.selection import Selection


async def test_filters_marks_and_orders_change_the_rows_and_are_kept(own, tmp_path):
    state = tmp_path / "browse.json"
    async with browsing(own, state=state) as (app, pilot):
        main, table = app.screen, table_of(app)
        await press(pilot, "slash", *"p=3", "enter")
        assert json.loads(state.read_text())["filters"] == ["p=3"]
        await press(pilot, "asterisk", "apostrophe")
        assert len(table.source) == 1
        assert json.loads(state.read_text())["marked"] == [table.source.row(0)[0]]
        await press(pilot, "apostrophe")
        assert main.choices.selection == Selection(where="p=3")
        orders = []
        await press(pilot, "l")
        for key in "ssRR":
            await press(pilot, key)
            orders.append(main.rows.ordering)
        assert orders == [Ordering("p", True), Ordering("p"), Ordering("p", True), Ordering("p")]
        assert table.ordering == orders[-1]


@pytest.mark.slow
async def test_a_fill_shows_its_rows_and_quitting_asks_first(own):
    async with browsing(own) as (app, pilot):
        before = len(table_of(app).source)
        await press(pilot, "f", "enter")
        await until(lambda: app.fill_state is not None and not app.fill_state.runs)
        await press(pilot, "escape")
        assert len(table_of(app).source) == Catalogue(own).count(status=()) == before + 712
        app.fill_state = FillState(FillRequest(1.6, (13,)))
        await press(pilot, "q", "n")
        assert (app.fill_state.state, app.leaving) == ("running", False)
        await press(pilot, "q")
        await pilot.press("y")
        await until(lambda: app.leaving)
        assert app.fill_state.state == "stopping"
