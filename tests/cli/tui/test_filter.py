"""The filter line: rows and their count follow what is typed."""

import pytest
from screens import ask, browsing, press, row_of, settle, shown, table_of, until

from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui.dialogs import LineDialog
from orbitdb.cli.tui.stored import Ordering
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.store.where import Patience


def told(app):
    return str(app.screen.query_one(".complaint").render())


async def typed(pilot, line):
    """Replace the line, as if it were typed fast, and wait for the rows."""
    pilot.app.screen.query_one("Input").value = line
    await settle(pilot)


@pytest.mark.slow
async def test_a_filter_counts_the_rows_that_the_view_held(filled_once):
    """The other choices, such as a status, stay, and the filter is compared with what they leave."""
    async with browsing(filled_once) as (app, pilot):
        app.screen.choices.selection = Selection(statuses=(Status.ORBIT,))
        await settle(pilot)
        catalogue = Catalogue(filled_once)
        held, found = catalogue.count(status="orbit"), catalogue.count(status="orbit", without="0202")
        await press(pilot, "slash")
        await typed(pilot, "not contains(code, '0202')")
        assert told(app) == f"{found:,} of {held:,} orbits"
        await press(pilot, "escape")
        app.screen.choices.selection = Selection(statuses=(Status.BOUNDARY,))
        await settle(pilot)
        assert "no orbits through a joint" in shown(app)


@pytest.mark.slow
async def test_rows_and_count_follow_the_filter_as_it_is_typed(filled_once):
    async with browsing(filled_once) as (app, pilot):
        main = app.screen
        everything = Catalogue(filled_once).count(Selection())
        await pilot.press("slash", *"p<3")
        await typed(pilot, "p < 3")
        assert told(app) == f"1 of {everything:,} words"
        await typed(pilot, "length < 1")
        assert (len(table_of(app).source), main.side.orbit) == (0, None)
        assert told(app) == f"0 of {everything:,} words"
        await typed(pilot, "length < 11")
        assert len(table_of(app).source) == 5
        assert told(app) == f"5 of {everything:,} words"
        assert main.sub_title == Selection(where="length < 11").describe()
        assert "13         2  10.4000000" in shown(app)
        await typed(pilot, "p")  # on the way to p < 11
        assert len(table_of(app).source) == 5
        assert "not a condition" in told(app)
        for more in (" an", " and time_reversal = 'se"):
            await typed(pilot, f"length < 11{more}")
            assert len(table_of(app).source) == 5
            assert any(part in told(app) for part in ("syntax error", "unrecognized", "incomplete"))
            assert app.screen.query(".complaint.-note")  # quietly
        chosen = Selection(where="length < 11 and time_reversal = 'self'")
        await typed(pilot, chosen.where)
        assert len(table_of(app).source) == Catalogue(filled_once).count(chosen)
        await press(pilot, "enter")
        assert app.screen is main
        assert main.choices.selection == chosen
        await press(pilot, "slash")
        await press(pilot, *" or p=3")  # goes on where the line ends
        assert app.screen.query_one("Input").value == f"{chosen.where} or p=3"
        await typed(pilot, "length < 1")
        await press(pilot, "enter")
        main.go_along(2.5)  # the list is empty because of the filter, not because of a
        assert main.choices.selection.a == 1.6


@pytest.mark.slow
async def test_escape_restores_filter_and_row_and_the_history_is_kept(filled_once):
    async with browsing(filled_once) as (app, pilot):
        await ask(pilot, "slash", "p > 3")
        await press(pilot, "j", "j")
        row = row_of(app)
        await pilot.press("slash")
        await typed(pilot, "p = 3")
        assert len(table_of(app).source) == 8
        await typed(pilot, "p = 3 or p > 3")
        assert table_of(app).row == row
        await typed(pilot, "p = 2")
        await press(pilot, "escape")
        assert app.screen.choices.selection == Selection(where="p > 3")
        assert table_of(app).row == row
        assert app.screen.side.orbit.code == row[0]
        await press(pilot, "slash", "escape", "j")  # no filter was tried, so the cursor still moves the orbit
        assert app.screen.side.orbit.code == row_of(app)[0] != row[0]
        await ask(pilot, "slash", "length < 11")
        await press(pilot, "slash", "ctrl+a", "ctrl+k", "enter")
        assert app.screen.choices.selection.where is None
        await press(pilot, "slash", "up", "enter")
        assert app.screen.choices.selection == Selection(where="length < 11")


@pytest.mark.slow
async def test_an_invalid_filter_is_reported_and_not_applied(filled_once):
    async with browsing(filled_once) as (app, pilot):
        await pilot.press("slash")
        await typed(pilot, "lenght < 3")
        assert "no such column: lenght" in told(app)
        assert app.screen.query(".complaint.-note")  # the line may be unfinished
        await press(pilot, "enter")
        assert not app.screen.query(".complaint.-note")  # shown in red
        assert isinstance(app.screen, LineDialog)
        await typed(pilot, "load_extension('x')")
        assert "it may not" in told(app)
        assert app.screen_stack[0].choices.selection.where is None


@pytest.mark.slow
async def test_values_given_with_a_filter_do_not_bind_the_next_one(filled_once):
    chosen = Selection(where="p < :cut", parameters={"cut": 3})
    async with browsing(filled_once, selection=chosen) as (app, pilot):
        assert len(table_of(app).source) == 1
        await pilot.press("slash")
        await typed(pilot, "p = 2 or p = 3")
        assert len(table_of(app).source) == 9
        await typed(pilot, "p = :c")
        await typed(pilot, "p = :cut")
        assert len(table_of(app).source) == 8
        await press(pilot, "escape")
        assert app.screen.choices.selection == chosen


@pytest.mark.slow
async def test_a_superseded_filter_stops_reading(filled_once, monkeypatch):
    """A filter that takes a minute neither blocks keys nor keeps running after the next one."""
    whole = Patience.look
    looks = []

    def look(patience):
        looks.append(patience)
        return whole(patience)

    monkeypatch.setattr(Patience, "look", look)
    terms = " + ".join(f"b.length * catalogue.length * {n}" for n in range(60))
    slow = f"(select sum({terms}) from catalogue b where b.length > catalogue.p) > p"
    async with browsing(filled_once) as (app, pilot):
        await pilot.press("slash")
        app.screen.query_one("Input").value = slow
        await until(lambda: len(looks) > 10 and told(app) == "reading …")
        await pilot.press("ctrl+u", *"p = 2")
        assert app.screen.query_one("Input").value == "p = 2"
        await typed(pilot, "p = 2")
        assert told(app).startswith("1 of ")
        count = len(looks)
        await pilot.pause(0.3)
        assert count == len(looks) > 10
        app.screen.query_one("Input").value = slow
        await until(lambda: len(looks) > count + 10 and told(app) == "reading …")
        await press(pilot, "escape")
        assert len(table_of(app).source) == app.catalogue.count(Selection())


@pytest.mark.slow
async def test_a_letter_typed_before_escape_but_handled_after_it_does_not_stop_the_rows(filled_once):
    async with browsing(filled_once) as (app, pilot):
        await press(pilot, "slash")
        dialog = app.screen
        await press(pilot, "escape")
        app.screen.rows.read(Selection())
        dialog.follow("p")
        await press(pilot, "l", "R")
        assert table_of(app).ordering == Ordering("p", descending=True)


@pytest.mark.slow
async def test_statuses_are_picked_from_a_list(filled_once):
    async with browsing(filled_once) as (app, pilot):
        main, everything = app.screen, len(table_of(app).source)
        await press(pilot, "O")
        assert "[x]" not in shown(app)
        places = [shown(app).index(text) for text in ("statuses", "[ ] an unstable", "space marks")]
        assert places == sorted(places)  # the title, the names and the hint follow one another
        await press(pilot, "space", "j", "j", "space")
        assert "its closed path leaves the stadium at this a" in shown(app)
        assert "[x] an unstable periodic orbit" in shown(app)
        assert "[ ] dynamically pruned" in shown(app)
        assert "[x] runs exactly through a joint" in shown(app)
        await press(pilot, "enter")
        assert app.screen is main
        assert main.choices.selection.statuses == (Status.ORBIT, Status.BOUNDARY)
        assert len(table_of(app).source) == app.catalogue.count(main.choices.selection) < everything
        await press(pilot, "O", "j", "space", "escape")
        assert main.choices.selection.statuses == (Status.ORBIT, Status.BOUNDARY)
        await press(pilot, "O", "space", "j", "j", "space", "enter")
        assert main.choices.selection.statuses == ()
        assert len(table_of(app).source) == everything


@pytest.mark.slow
async def test_the_filter_completes_names_of_columns(filled_once):
    async with browsing(filled_once) as (app, pilot):
        await press(pilot, "slash", *"leng", "right", *"<11 and time", "right")
        assert app.screen.query_one("Input").value == "length<11 and time_reversal"
        for key in (*" = 'sel", "right"):
            await press(pilot, key)
        assert app.screen.query_one("Input").value.endswith("= 'sel")  # a text is no column
        await press(pilot, *"f'", "enter")
        assert app.screen.choices.selection.where == "length<11 and time_reversal = 'self'"
        assert len(table_of(app).source) == 1


@pytest.mark.slow
async def test_the_total_is_the_subset_without_its_filter_and_advice_is_for_the_screen(filled_once):
    chosen = Selection(periods=((2, 4),), statuses=(Status.ORBIT,))
    total = Catalogue(filled_once).count(chosen)
    async with browsing(filled_once, selection=chosen) as (app, pilot):
        await pilot.press("slash")
        await typed(pilot, "length < 11")
        assert told(app) == f"5 of {total} orbits"
        for wrong in ("lenght < 3", "p = :cut", "length <"):
            await typed(pilot, wrong)
            assert told(app)
            assert "orbitdb" not in told(app)
            assert "--parameter" not in told(app)
            assert wrong not in told(app)  # the line itself stands above


async def test_a_view_without_rows_says_so(filled_once):
    async with browsing(filled_once, selection=Selection(statuses=(Status.BOUNDARY,))) as (app, _):
        assert "no orbits through a joint" in shown(app)
