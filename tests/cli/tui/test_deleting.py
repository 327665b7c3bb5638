"""Another process deletes rows while the screen shows them."""

import shutil

import pytest
from screens import LARGE, browsing, press, settle, shown, table_of

from orbitdb.catalogue import Catalogue
from orbitdb.filling.fill import fill_periods
from orbitdb.selection import Selection


@pytest.fixture
def path(filled_once, tmp_path):
    return shutil.copy(filled_once, tmp_path / "orbits.db")


def notes(app):
    return [note.message for note in app._notifications]


async def test_a_row_that_another_process_deleted_is_no_end(path, cli):
    """`G` needs rows that are not on the screen, and no longer in the file."""
    async with browsing(path, LARGE) as (app, pilot):
        before = len(table_of(app).source)
        assert cli("delete", "--db", str(path), "--a", "1.6", "--p", "8", "--yes").code == 0
        await press(pilot, "G")
        assert sum("another process deleted" in note for note in notes(app)) == 1
        rows = Catalogue(path).count(Selection())
        assert len(table_of(app).source) == rows < before
        await press(pilot, "G")
        assert f"{rows:,} of {rows:,}" in shown(app)
        assert app.screen.side.orbit.p == 7


@pytest.mark.slow
async def test_the_screen_notices_a_deletion_by_itself(path, cli):
    """The rows on the screen are in memory, so only the file can say that they are gone."""
    async with browsing(path, LARGE) as (app, pilot):
        app.screen.look_for_changes()
        await settle(pilot)
        assert notes(app) == []
        assert cli("delete", "--db", str(path), "--a", "1.6", "--yes").code == 0
        app.screen.look_for_changes()  # as it does every few seconds
        await settle(pilot)
        assert sum("another process deleted" in note for note in notes(app)) == 1
        assert len(table_of(app).source) == 0
        assert "fill the catalogue" in shown(app)


@pytest.mark.slow
async def test_rows_that_another_process_adds_are_no_deletion(path):
    async with browsing(path, LARGE) as (app, pilot):
        [*fill_periods(path, 1.0, [3])]
        app.screen.look_for_changes()
        await settle(pilot)
        [*fill_periods(path, 1.6, [9])]
        rows = Catalogue(path).count(Selection())
        await press(pilot, "slash", *"p = 9")
        assert f"{Catalogue(path).count(p=9, status='all'):,} of {rows:,} words" in shown(app)
        await press(pilot, "escape")
        app.screen.look_for_changes()
        await settle(pilot)
        assert notes(app) == []
        assert len(table_of(app).source) == rows
