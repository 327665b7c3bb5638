"""Choices as text, as links and in files, and the keys that step through their values."""

import json
import re
from dataclasses import asdict

import pytest
from screens import ask, browsing, press, row_of, screen_lines, shown, table_of

from orbitdb.cli.tui.export import write_rows
from orbitdb.cli.tui.panels import filter_bar
from orbitdb.cli.tui.stored import SHOWABLE, USUAL, Kept, Ordering, State
from orbitdb.columns import IN_CATALOGUE
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.store.sqlite import never


def heading(app):
    return screen_lines(app)[3]


@pytest.mark.slow
async def test_chosen_columns_are_saved_and_the_sorted_one_is_always_visible(filled_once, tmp_path):
    state = tmp_path / "new" / "browse.json"
    async with browsing(filled_once, state=state) as (app, pilot):
        await press(pilot, "C", "space", "j", "j", "K", "K", "k", "end")
        assert "[ ] solver" in shown(app)
        await press(pilot, "K", "J", "enter")  # moving a column shows it
        assert [*app.screen.rows.columns] == ["code", "status", "length", *USUAL[4:], "solver"]
        assert heading(app).split()[:3] == ["│code", "p▲", "status"]  # p was hidden, but it sorts the rows
        await press(pilot, *"lll", "s")
        assert app.screen.rows.ordering == Ordering("lambda_d")
        await press(pilot, *"hhh")
        assert heading(app).split()[:2] == ["│code", "lambda_d▲"]
        columns = ("code", "lambda_d")
        (last,) = app.catalogue.rows(Selection(), columns=columns, order="lambda_d desc", limit=1)
        await press(pilot, *"lll", "R", "g")
        assert (row_of(app)[0], row_of(app)[app.screen.rows.table.source.fields.index("lambda_d")]) == last
        await press(pilot, "K", "ctrl+p")
        app.theme = "nord"
        await press(pilot, "escape")
    async with browsing(filled_once, state=state) as (app, pilot):  # all this is kept
        assert heading(app).split()[:2] == ["│code", "lambda_d▼"]
        assert (app.screen.rows.by_class, app.theme) == (True, "nord")
        await press(pilot, "C", "R", "enter")
        assert app.screen.rows.columns == USUAL
    assert json.loads(state.read_text())["columns"] == list(USUAL)


@pytest.mark.slow
async def test_typing_letters_finds_names_in_lists(filled_once):
    async with browsing(filled_once) as (app, pilot):
        await press(pilot, "C", *"lep", "space", "enter")  # no name starts with lep: p starts anew
        assert "p" not in app.screen.rows.columns
        await press(pilot, "C", *"wal", "space", "enter")
        assert app.screen.rows.columns[-1] == "walls"


@pytest.mark.slow
async def test_marked_orbits_and_filters_are_kept_and_exported(filled_once, tmp_path):
    state, file = tmp_path / "browse.json", tmp_path / "marked.csv"
    async with browsing(filled_once, state=state) as (app, pilot):
        await press(pilot, "apostrophe")
        assert not app.screen.choices.selection.where  # no orbit is marked yet
        await press(pilot, "asterisk", "j", "j", "asterisk")
        assert "13      *  2" in shown(app)
        await ask(pilot, "slash", "p < 4")
        await press(pilot, "apostrophe")
        assert len(table_of(app).source) == 2
        told = write_rows(app.catalogue, app.screen.view, file, never)
        assert told.startswith("2 rows")
        await press(pilot, "asterisk")
        assert [row_of(app)[0], len(table_of(app).source)] == ["13", 1]
        await press(pilot, "apostrophe")
        assert app.screen.choices.selection.where == "p < 4"
    assert file.read_text().count("\n") == 3
    async with browsing(filled_once, state=state) as (app, pilot):
        await press(pilot, "apostrophe")
        assert len(table_of(app).source) == 1
        await press(pilot, "apostrophe", "slash", "up", "enter")  # filters are kept, too
        assert app.screen.choices.selection.where == "p < 4"
    kept = json.loads(state.read_text())
    assert (kept["marked"], kept["filters"]) == (["13"], ["p < 4"])


def mark(kept, word):
    with kept.changing() as state:
        state.marked.append(word)


def test_an_invalid_state_file_is_left_unchanged(tmp_path):
    path = tmp_path / "browse.json"
    for text in ("[", "[]", "[" * 9999, '{"marked": ["9"]}', '{"filters": 3}', "\xff"):
        path.write_bytes(text.encode("latin-1"))
        told: list[str] = []
        kept = Kept(path, told.append)
        assert not kept.load()
        mark(kept, "13")
        assert ["move it away" in line for line in told] == [True, True]
        assert kept.state.marked == ["13"]
        assert path.read_bytes() == text.encode("latin-1")


def test_marks_are_words_in_any_rotation_and_the_last_filter_comes_last(tmp_path):
    path = tmp_path / "browse.json"
    path.write_text('{"marked": ["310", "13", "031"]}')
    kept = Kept(path, print)
    for where in ("p = 2", "p = 3", "p = 2"):
        kept.remember(where)
    assert kept.state == State(marked=["031", "13"], filters=["p = 3", "p = 2"])
    assert json.loads(path.read_text()) == asdict(kept.state)


def test_two_sessions_keep_each_others_marks(tmp_path):
    told: list[str] = []
    one, other = (Kept(tmp_path / "browse.json", told.append) for _ in range(2))
    mark(one, "13")
    mark(other, "013")
    mark(one, "031")
    assert one.state == State(marked=["13", "013", "031"])
    (tmp_path / "file").touch()
    assert not told
    mark(Kept(tmp_path / "file" / "browse.json", told.append), "13")
    assert "cannot be read" in told[0]


def test_every_column_except_a_can_be_shown():
    assert {*SHOWABLE} == {column.name for column in IN_CATALOGUE} - {"a"}


def test_keys_cycle_through_the_values_of_a_criterion():
    chosen, seen = Selection(), []
    for _ in range(6):
        chosen = filter_bar.turned(chosen, "statuses", filter_bar.RINGS["statuses"])
        seen.append(chosen.statuses)
    cycle = [(Status.ORBIT,), (Status.DYNAMICAL,), (Status.BOUNDARY,), (Status.UNRESOLVED,), ()]
    assert seen == [*cycle, cycle[0]]  # pruned words, which take a large fill, are chosen from the list
    chosen = Selection()
    several = Selection(statuses=(Status.ORBIT, Status.BOUNDARY))
    assert filter_bar.turned(several, "statuses", filter_bar.RINGS["statuses"]).statuses == (Status.ORBIT,)
    for reversal in ("self", "pair", None):
        chosen = filter_bar.turned(chosen, "time_reversal", filter_bar.RINGS["time_reversal"])
        assert chosen.time_reversal == reversal
    ring = ((), ((2, 2),), ((4, 4),), ((5, 5),))
    for step, periods in ((1, [2, 4, 5]), (-1, [5, 4, 2])):
        for p in periods:
            chosen = filter_bar.turned(chosen, "periods", ring, step)
            assert chosen.periods == ((p, p),)
        chosen = filter_bar.turned(chosen, "periods", ring, step)
        assert chosen.periods == ()
    for others in (((2, 4), (5, 5)), ((3, 3),)):  # none of them a single period
        assert filter_bar.turned(Selection(periods=others), "periods", ring).periods == ((2, 2),)


def linked(line):
    """Return the actions of a line of choices, with the key and the text of each."""
    parts = re.findall(r"\[b \$key on \$panel\] (.*?)\[/\]\[@click=([^\]]*)\] (.*?) \[/\]", line)
    return [(action, key, text) for key, action, text in parts]


def test_choices_link_to_their_actions_and_name_their_keys():
    assert [text for _, _, text in linked(filter_bar.chips(Selection(), [1.6]))] == [
        "1.6", "p all", "every status", "any reversal", "no filter"
    ]  # fmt: skip
    assert linked(filter_bar.chips(Selection(3.0), [1.0, 1.6]))[0] == ("half_length", "a", "3, not filled")
    statuses = (Status.ORBIT, Status.BOUNDARY)
    chosen = Selection(1.0, ((2, 4), (7, 7)), statuses, "self", where="code like '[1]'")
    assert linked(filter_bar.chips(chosen, [chosen.a, 7.0])) == [
        ("half_length", "a", "1, of 2 values stored"),
        ("turn('periods')", r"\[ ]", "p 2-4, 7"),
        ("turn('statuses')", "o", "orbit, boundary"),
        ("turn('time_reversal')", "r", "self-retracing"),
        ("filter", "/", r"where code like '\[1]'"),
    ]


@pytest.mark.parametrize(
    ("chosen", "told"),
    [
        ({"length": (None, 15)}, "with length <= 15"),
        ({"contains": "11", "symmetry": "x,T,xT"}, "with symmetry x,T,xT containing 11"),
        ({"exists": 1.0, "not_at": 0.5}, "that exist at a = 1 and not at a = 0.5"),
        ({"margin": (0.1, None), "where": "p < :top", "parameters": {"top": 5}},
         "with margin >= 0.1 where p < :top (top = 5)"),
    ],
)  # fmt: skip
def test_criteria_without_a_field_of_their_own_come_last(chosen, told):
    shown = filter_bar.chips(Selection.from_criteria(**chosen), [])
    assert linked(shown)[-1] == ("filter", "/", told)
