"""A view can be written down as a command and in Python, undone, and filtered by a value."""

import csv
import shlex
from functools import partial
from io import StringIO
from pathlib import Path

import pytest
from screens import ask, browsing, press, row_of, screen_lines, settle, shown, table_of
from textual import events

import orbitdb
from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui.panels.drawing import OrbitDrawing
from orbitdb.cli.tui.panels.filter_bar import View, both, equals
from orbitdb.cli.tui.stored import Ordering, known_columns
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.symbols.symmetry import MIRROR_X, REVERSE, images_of
from orbitdb.symbols.words import least_rotation

VIEWS = [
    View(Selection()),
    View(
        Selection.from_criteria(
            a=1.6, p="2-4,6", status="orbit,boundary", time_reversal="pair", where="code <> '013' or p > 3"
        ),
        Ordering("length", True),
        known_columns(["p", "status", "length"]),
    ),
    View(Selection.from_criteria(a=1.0, symmetry="T", contains="3", length=(None, 20.5), margin=(1e-4, 2))),
    View(
        Selection.from_criteria(a=1.6, where="length < :most -- 'short'", parameters={"most": 12}),
        Ordering("code"),
    ),
    View(
        Selection.from_criteria(
            a=1.6,
            where="code <> code(:word) and p / :two >= 1.5 and p < :most and status <> :status",
            parameters={"word": "13", "two": 2.0, "most": 5, "status": "it's '02'"},
        )
    ),
    View(Selection.from_criteria(a=1.6, status="geometric"), Ordering("code", True)),
    View(Selection.from_criteria(a=1.6, without=["02", "31"], walls=2, quarter_length=(3, 9))),
    View(Selection.from_criteria(a=1.6, p="2-5", margin=(0, 0.5))),
]


@pytest.mark.parametrize("view", VIEWS)
def test_the_command_and_the_line_of_python_give_the_rows_of_the_view(cli, varied, view):
    names = list(view.columns)
    rows = list(Catalogue(varied).rows(view.selection, columns=names, order=str(view.ordering)))
    program, *arguments = shlex.split(view.command(varied))
    assert program == "orbitdb"
    head, *lines = csv.reader(StringIO(cli(*arguments, "--format=csv").out))
    assert head == names
    assert [line[0] for line in lines] == [row[0] for row in rows] != []
    subset = eval(view.python(varied), {"Catalogue": orbitdb.Catalogue})
    assert subset.code.tolist() == [row[0] for row in rows]


def test_the_births_that_a_view_asks_for_are_written_down():
    view = View(Selection.from_criteria(a=1.6, exists=[1.5, 2], not_at=0.5))
    assert "--exists 1.5 --exists 2 --not-at 0.5" in view.command(Path("x.db"))
    assert "exists=[1.5, 2.0], not_at=[0.5]" in view.python(Path("x.db"))


@pytest.mark.slow
async def test_views_are_copied_and_undone(varied):
    async with browsing(varied) as (app, pilot):
        main = app.screen
        begun = main.rows.columns
        await press(pilot, "o", "slash", *"p=3", "enter", *"ll", "s", "a", "up", "enter")
        last = View(
            Selection(1.0, statuses=(Status.ORBIT,), where="p=3"), Ordering("length"), main.rows.columns
        )
        assert main.view == last
        await press(pilot, "E", "j", "enter")
        assert app.clipboard == last.python(varied)
        await press(pilot, "E", "enter")
        assert app.clipboard == last.command(varied)
        seen = []
        for _ in range(4):
            await press(pilot, "u")
            seen.append((main.view.selection.a, main.view.ordering.column, main.view.selection.where))
            assert main.view.selection == table_of(app).source.chosen.selection
        assert seen == [(1.6, "length", "p=3"), (1.6, "p", "p=3"), (1.6, "p", None), (1.6, "p", None)]
        assert main.view == View(Selection(), columns=begun)
        await press(pilot, "u")
        assert "no view to go back to" in [*app._notifications][-1].message


@pytest.mark.slow
async def test_undo_takes_back_a_filter_whole_and_not_keystroke_by_keystroke(varied):
    """Some of its beginnings are filters of their own, which the table shows while one types."""
    async with browsing(varied) as (app, pilot):
        main = app.screen
        begun = main.view
        await press(pilot, "slash", *"p=2 or p=3", "enter")
        assert main.view.selection.where == "p=2 or p=3"
        await press(pilot, "u")
        assert main.view == begun
        await press(pilot, "u")
        assert "no view to go back to" in [*app._notifications][-1].message


async def test_a_status_without_words_has_no_classes(varied):
    """Also if a filter is set, beside which the rows without it are counted."""
    chosen = Selection.from_criteria(a=1.6, status="unresolved", where="p > 2")
    async with browsing(varied, selection=chosen) as (app, pilot):
        await press(pilot, "K")
        assert app.screen.rows.report == "0 of 0 classes"


async def test_marking_all_statuses_means_every_status(varied):
    async with browsing(varied, selection=Selection.from_criteria()) as (app, pilot):
        await press(pilot, "O", *["down", "space"] * 4, "enter")
        assert app.screen.choices.selection == Selection.from_criteria(status="all")
        assert "every status" in shown(app)


async def test_stepping_through_the_statuses_shows_every_status_once(varied):
    """A filter by status means every status."""
    async with browsing(varied, selection=Selection.from_criteria(where="status <> 'x'")) as (app, pilot):
        seen = []
        for _ in range(6):
            seen.append(shown(app).splitlines()[1])
            await press(pilot, "o")
        assert [line for line in seen if "every status" in line] == [seen[0], seen[5]]


async def test_undoing_restores_columns_and_order(varied):
    async with browsing(varied) as (app, pilot):
        main = app.screen
        begun = main.view
        heading = screen_lines(app)[3]
        await press(pilot, "C", "j", "j", "space", "enter")
        assert main.rows.columns != begun.columns
        chosen, other = main.view, screen_lines(app)[3]
        assert other != heading
        await press(pilot, "R")
        assert main.view.ordering.descending
        await press(pilot, "u")
        assert (main.view, screen_lines(app)[3]) == (chosen, other)
        await press(pilot, "u")
        assert (main.view, screen_lines(app)[3]) == (begun, heading)


async def test_all_symmetries_are_shown_where_there_is_room(varied):
    async with browsing(varied, size=(200, 24)) as (app, pilot):
        await press(pilot, "K")
        assert " x,y,xy,T,xT,yT,xyT " in "\n".join(screen_lines(app))


@pytest.mark.slow
def test_the_value_of_each_column_chooses_its_row(varied):
    names = [*VIEWS[0].columns, "rules", "born", "maslov"]
    catalogue = Catalogue(varied)
    pruned = catalogue.rows(columns=names, status="geometric")
    for row in [*[*catalogue.rows(columns=names)][::250], next(iter(pruned))]:
        for name, value in zip(names, row, strict=True):
            where = both(equals(name, value), f"code = '{row[0]}'")
            found = list(catalogue.rows(columns=("code",), status=row[names.index("status")], where=where))
            assert found == [row[:1]], where
    assert equals("code", "it's") == "code = 'it''s'"


@pytest.mark.parametrize(("column", "where"), [("area", "area < 0"), ("margin", "margin < 0")])
def test_a_negative_value_under_the_cursor_chooses_its_row(varied, column, where):
    catalogue = Catalogue(varied)
    ask = partial(catalogue.rows, status="orbit,dynamical", columns=("code", column))
    (row,) = ask(where=where, limit=1)
    assert row[1] < 0
    assert row in [*ask(where=equals(column, row[1]))]
    assert all(value < 0 for _, value in ask(where=equals(column, row[1])))


@pytest.mark.parametrize(
    "where", ["p = 3 or p = 4", "p = 3 OR p = 4", "(p = 3)or(p = 4)", "p in (3, 4) -- short", "p in (3, 4)"]
)
def test_a_condition_limits_all_that_a_filter_allows(varied, where):
    catalogue = Catalogue(varied)
    both_hold = catalogue.count(p="3-4", where="length < 11")
    assert catalogue.count(where=both(where, "length < 11")) == both_hold > 0


@pytest.mark.slow
async def test_a_key_filters_by_the_value_under_the_cursor_and_pasted_codes_are_found(varied):
    async with browsing(varied) as (app, pilot):
        await press(pilot, "j", "j", "l", "equals_sign", *"ll", "equals_sign")
        assert app.screen.choices.selection.where == "p = 3 and status = 'orbit'"
        assert row_of(app)[0] == "031"
        await press(pilot, "u", "u")
        for text, code in (("3213\n", "3213"), ("(13)^2 3", "13133")):
            app.post_message(events.Paste(text))
            await settle(pilot)
            assert app.screen.side.orbit.code == code


@pytest.mark.slow
async def test_one_row_a_class_and_columns_that_say_the_same_are_left_out(varied):
    async with browsing(varied, (160, 48), Selection(periods=((4, 5),))) as (app, pilot):
        main, table = app.screen, table_of(app)
        words, classes = (
            [
                code
                for (code,) in app.catalogue.rows(
                    p="4-5", a=1.6, status="all", columns=("code",), classes=each
                )
            ]
            for each in (False, True)
        )
        assert [table.source.row(n)[0] for n in range(len(table.source))] == words
        await press(pilot, "K")
        assert [table.source.row(n)[0] for n in range(len(table.source))] == classes
        assert main.rows.report == f"{len(classes)} of {len(classes)} classes"
        assert main.rows.border_title == "classes"
        await press(pilot, "E", "enter")
        assert "--classes" in app.clipboard
        other = images_of("0133")[MIRROR_X]  # of the same class
        await ask(pilot, "c", other)
        assert (row_of(app)[0], main.side.orbit.code) == ("0133", other)
        assert {"p", "status", "time_reversal"} <= {*table._present()}
        main.choices.selection = Selection(periods=((4, 4),), statuses=(Status.ORBIT,), time_reversal="pair")
        await settle(pilot)
        assert not {"p", "status", "time_reversal"} & {*table._present()}
        await press(pilot, "u", "u")
        assert not main.rows.by_class
        assert len(table.source) == len(words)


@pytest.mark.slow
async def test_a_second_orbit_is_drawn_with_the_one_under_the_cursor(varied):
    async with browsing(varied, (120, 40)) as (app, pilot):
        drawing = app.screen.query_one(OrbitDrawing)
        await press(pilot, "asterisk", "j", "j", "j", "P", "v")
        assert drawing.partner.code == "13"  # the marked one
        assert drawing.border_title == "phase space, with 13"
        assert shown(app).count("○") == 2
        await press(pilot, "g", "v")
        assert least_rotation(drawing.partner.code) == "13"  # its reverse: the mark is on this one
        await press(pilot, "asterisk", *"jjjjjj")
        reverse = images_of(app.screen.side.orbit.code)[REVERSE]
        assert least_rotation(drawing.partner.code) == least_rotation(reverse)
        assert "with " in drawing.border_title
        await press(pilot, "P")
        assert drawing.partner is None
