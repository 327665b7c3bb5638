"""The terminal UI, driven by keys and mouse against a filled catalogue, at two sizes."""

import asyncio
import csv
import re
import shutil
import threading
from functools import partial
from pathlib import Path

import pytest
from contents import made
from screens import LARGE, SMALL, browsing, press, row_of, screen_lines, send, shown, table_of, until, write
from solutions import entropy, lyapunov
from textual.widgets import Input
from there import there

from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui.export import Export, save_orbit, write_rows
from orbitdb.cli.tui.fill_dialog import FillDialog, parse_request
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.panels.drawing import OrbitDrawing
from orbitdb.cli.tui.panels.facts import FactsPanel
from orbitdb.cli.tui.panels.filter_bar import View
from orbitdb.cli.tui.screens import QuestionDialog, Working
from orbitdb.cli.tui.stored import Ordering
from orbitdb.errors import InputError
from orbitdb.filling.fill import fill_periods, fill_words
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.store.sqlite import never
from orbitdb.symbols.words import parse, primitive_root


@pytest.fixture(scope="session")
def filled(made_once):
    def make(path):
        made(path, fill_periods(path, 1.6, range(2, 8)), fill_periods(path, 1.0, range(2, 7)))

    return made_once("tui", make)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "chosen", "rows", "told"),
    [
        ("1232131", Selection(periods=((2, 4),)), True, "1232131 has no row here"),
        ("1232131", Selection(where="p > 50"), False, "1232131 has no row here"),
        ("1^20 3", Selection(periods=((2, 4),)), True, "1^20 3 is not stored"),
        ("3131", Selection(), True, "3131 repeats 31 (twice): using 31"),
    ],
)
async def test_the_screen_opens_at_a_code_outside_the_subset(filled, code, chosen, rows, told):
    async with browsing(filled, code=code, selection=chosen, notifications=True) as (app, pilot):
        assert app.screen.side.orbit.code == primitive_root(parse(code))
        assert told in " ".join([shown(app), *(note.message for note in app._notifications)])
        assert (table_of(app).row is not None) == rows
        await press(pilot, "escape")
        if rows:
            assert app.screen.side.orbit.code == "13"


@pytest.mark.slow
@pytest.mark.parametrize(
    "order", [("find", "rows", "rows"), ("rows", "find", "rows"), ("rows", "rows", "find")]
)
async def test_first_rows_all_rows_and_the_orbit_may_arrive_in_any_order(filled, monkeypatch, order):
    arrived: dict[str, list[partial[None]]] = {"rows": [], "find": []}

    def find_at_once(self, group, find, take, fail=None):
        found = find(never)
        arrived[group] += [partial(take, part) for part in (found if group == "rows" else [found])]

    monkeypatch.setattr(Working, "in_thread", find_at_once)
    async with browsing(filled, code="0132") as (app, pilot):
        for group in order:
            arrived[group].pop(0)()
            await pilot.pause()
        rows, place = app.screen.rows, there(table_of(app).source.position("0132"))
        assert app.screen.side.orbit.code == row_of(app)[0] == "0132"
        assert (rows.border_title, rows.border_subtitle) == ("words", f"{place + 1} of {rows.total:,}")


@pytest.mark.slow
async def test_a_particle_runs_and_phase_space_shows_the_bounces(filled):
    async with browsing(filled) as (app, pilot):
        drawing = app.screen.query_one(OrbitDrawing)
        await pilot.press("space")
        await asyncio.wait_for(until(lambda: drawing.particle > 0), 10)
        before = drawing.particle
        drawing.step()
        way = (drawing.particle - before) % 1 * app.screen.side.orbit.length
        assert way == pytest.approx(0.125)  # 2.5 units of length per second, 20 frames per second
        drawing.particle = 0.9999
        drawing.step()
        assert 0 < drawing.particle < 0.1  # after one round
        await pilot.pause()
        assert "●" in shown(app)
        await press(pilot, "d")
        before = drawing.particle
        drawing.step()
        assert drawing.particle == before  # another screen is above it
        await press(pilot, "escape", "space")
        assert drawing.particle is None
        await press(pilot, "j", "v")
        assert drawing.phase
        assert shown(app).count("●") == 3
        await press(pilot, "v")
        assert not drawing.phase


@pytest.mark.slow
def test_statistics_of_a_subset_count_only_its_words(filled):
    from orbitdb.cli.tui.statistics_screen import curves_of
    from orbitdb.orbits.exponents import OrbitClasses

    catalogue = Catalogue(filled)
    chosen = Selection(contains="13", statuses=(Status.ORBIT,))
    found = catalogue.statistics(chosen)
    rows = list(catalogue.rows(chosen, columns=("p", "length", "lyapunov", "walls")))
    import numpy as np

    p, length, exponent, walls = np.array(rows).T
    single = OrbitClasses(p.astype(int), np.ones(len(p), int), length, exponent, walls.astype(int))
    assert found["N"] == entropy(single, 7).N.tolist()
    assert found["lambda_c"] == pytest.approx(lyapunov(single, 7).lambda_c, nan_ok=True)
    assert sum(found["N_c"]) == len(rows)
    even = catalogue.statistics(p="4,6")
    assert even["p"] == [4, 6]
    whole = catalogue.statistics(p="2-6")
    for name in ("N", "K_0", "h_zeta", "lambda_d_pair", "lambda_d_sum_rule"):
        assert even[name] == [whole[name][2], whole[name][4]]
    assert np.isfinite(curves_of(even, None)["entropy"][0].y).all()
    assert found["lambda_d_sum_rule"] == [None] * len(found)


@pytest.mark.slow
async def test_a_long_fill_asks_first_and_can_be_stopped_and_resumed(tmp_path):
    path = tmp_path / "new.db"
    async with browsing(path) as (app, pilot):
        await press(pilot, "f", *"2-14")
        await send(app, "enter", QuestionDialog)
        await until(lambda: "2,697,273 words to fill" in shown(app))
        assert "Cancel (n)" in shown(app)
        assert "Fill (y)" in shown(app)
        await send(app, "n", FillDialog)
        assert app.fill_state is None
        await press(pilot, "enter")
        await send(app, "y", FillDialog)
        await until(lambda: app.fill_state is not None and app.fill_state.done)
        await send(app, "escape", MainScreen)
        await send(app, "q", QuestionDialog)
        await send(app, "n", MainScreen)
        await send(app, "f", FillDialog)
        await until(lambda: app.screen.query("#stop"))
        app.screen.query_one("#stop").press()
        await until(lambda: app.fill_state.state == "stopped")
    done = [fill.p for fill in Catalogue(path).fills(a=1.6) if fill.state == "done"]
    assert 14 not in done
    made(path, fill_periods(path, 1.6, range(2, 8)))
    counts = {fill.p: fill.n_c for fill in Catalogue(path).fills(a=1.6)}
    assert [counts[p] for p in range(2, 8)] == [1, 8, 32, 80, 188, 376]


@pytest.mark.parametrize(
    ("texts", "complaint"),
    [
        (("x", "2-5", ""), "is not a number"),
        (("1_6", "2-5", ""), "is not a number"),
        (("-1", "2-5", ""), "half length"),
        (("1.6", "two", ""), "periods"),
        (("1.6", "1-5", ""), "the least period is 2"),
        (("1.6", "2-5", "9"), "symbol"),
    ],
)
def test_invalid_requests_to_fill_are_refused(texts, complaint):
    with pytest.raises(InputError, match=complaint):
        parse_request(*texts)


def test_the_dialog_reads_periods_as_the_command_does():
    for text, periods in (("4", (2, 3, 4)), ("2,4-5", (2, 4, 5)), ("4-4", (4,))):
        assert parse_request("1.6", text, "").periods == periods
    assert parse_request("1.6", "", "1^2 3, 1313").words == ("113", "13")


@pytest.mark.parametrize("name", ["rows.tsv", "orbit.svg", pytest.param("orbit.png", marks=pytest.mark.slow)])
def test_every_kind_of_export_writes_the_shown_data(filled, tmp_path, name):
    catalogue, path, few = Catalogue(filled), tmp_path / name, Selection(periods=((2, 4), (9, 9)))
    if name == "rows.tsv":
        told = write_rows(Catalogue(filled), View(few, Ordering("length", True)), path, never)
    else:
        told = save_orbit(catalogue.find("013", a=1.6), False, path)
    assert str(path) in told
    if name == "rows.tsv":
        assert "period 9 is not filled" in told
        head, *rows = csv.reader(path.read_text().splitlines(), delimiter="\t")
        found = [row[head.index("code")] for row in rows]
        assert found == [code for (code,) in catalogue.rows(few, columns=("code",), order="length desc")]
    elif name == "orbit.svg":
        corners = there(re.search(r'<polygon points="([^"]*)"', path.read_text()))[1].split()
        assert len(corners) == 3
    else:
        assert path.read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InputError):
        save_orbit(None, False, tmp_path / "x.svg")
    with pytest.raises(InputError):
        write_rows(
            Catalogue(tmp_path / "no.db", missing_ok=True), View(Selection()), tmp_path / "x.csv", never
        )


@pytest.mark.slow
async def test_an_export_in_progress_is_not_repeated_and_quitting_asks_first(filled, tmp_path):
    path = tmp_path / "rows.csv"
    async with browsing(filled, notifications=True) as (app, pilot):
        app.exports.add(path)
        await press(pilot, "e")
        await write(pilot, str(path), "enter")
        assert f"{path} is still being written" in [note.message for note in app._notifications][-1]
        assert not path.exists()
        await press(pilot, "q")
        assert isinstance(app.screen, QuestionDialog)
        assert "An export is being written" in shown(app)
        await press(pilot, "escape")
        app.exports.clear()
        await press(pilot, "e")
        await write(pilot, str(path), "enter")
        begun, done = [note.message for note in app._notifications][-2:]
        assert begun == f"writing {path} ..."
        assert done.endswith(f"rows written to {path}")
        assert path.exists()
        assert not app.exports


@pytest.mark.slow
async def test_quitting_right_after_an_export_begins_asks_first(filled, tmp_path):
    """The answer of the dialog may still be on its way through the main screen."""
    go_on = threading.Event()
    async with browsing(filled) as (app, _):
        export = Export(tmp_path / "rows.csv", lambda _: "written" if go_on.wait(60) else "")
        app.screen.call_next(app.post_message, export)
        await app.run_action("quit")
        app.screen.call_later(lambda: None)  # a busy screen calls what is next only after other messages
        await until(lambda: isinstance(app.screen, QuestionDialog) or app._exit)
        assert isinstance(app.screen, QuestionDialog)
        go_on.set()


@pytest.mark.slow
async def test_the_shown_picture_can_be_saved_as_a_figure(filled, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    async def saved(pilot, name):
        await press(pilot, "e")
        await write(pilot, name, "enter")
        return (tmp_path / name).read_text(encoding="utf-8")

    async with browsing(filled, LARGE) as (app, pilot):
        await press(pilot, "j", "v")
        assert "alpha" in await saved(pilot, "phase.svg")
        await press(pilot, "e")
        await write(pilot, "phase.svg")
        assert "phase.svg exists and will be replaced: the bounces in phase space" in shown(app)
        await press(pilot, "escape", "d")
        drawn = await saved(pilot, "histogram.svg")
        assert all(text in drawn for text in ("words", "length"))
        assert "without" not in drawn  # words without a length have no bar
        await press(pilot, "e")
        await write(pilot, "rows.csv")
        assert "rows.csv: end the name in .png, .svg, .pdf" in shown(app)
        await press(pilot, "escape", "escape", "S")
        drawn = await saved(pilot, "averages.svg")
        assert all(text in drawn for text in ("topological entropy", "per bounce", "zeta"))


@pytest.mark.slow
async def test_the_proposed_file_depends_on_the_focus(filled):
    async with browsing(filled) as (app, pilot):
        for keys, name, told in (("e", "orbits.csv", "the chosen rows"), ("tab e", "13.svg", "the orbit in")):
            await press(pilot, *keys.split())
            assert app.screen.query_one(Input).value == name
            assert told in shown(app)
            await press(pilot, "escape")


@pytest.mark.slow
async def test_a_very_small_screen_stacks_rows_and_facts(filled):
    def room(app):
        table, facts = table_of(app), app.screen_stack[0].query_one(FactsPanel)
        assert min(table.size.width, facts.size.width) >= 36
        return table.size.height - 1, facts.size.height

    async with browsing(filled, size=(40, 12)) as (app, pilot):
        assert room(app) == (3, 4)
        assert "status " in shown(app)
        await press(pilot, "tab")
        assert room(app) == (1, 6)
        assert "lyapunov " in shown(app)
        await press(pilot, "enter")
        assert "◆" in shown(app)
        assert app.screen.query_one(FactsPanel).size.height >= 5
        await press(pilot, "escape", "d")
        assert all(app.screen.query_one(name).size.width >= 36 for name in ("#tallies", "#histogram"))


@pytest.mark.slow
async def test_a_long_code_leaves_room_for_other_columns(filled, tmp_path):
    path, code = Path(shutil.copy(filled, tmp_path)), "1" * 40 + "3"
    fill_words(path, [code], 1.6)

    for size in (SMALL, LARGE):
        async with browsing(path, size, Selection(periods=((2, 2), (41, 41)))) as (app, _):
            _, _, _, heading, *lines = screen_lines(app)
            assert re.search(r"code +p▲ +length ", heading)
            assert any("│1^40 3 " in line for line in lines)


@pytest.mark.slow
async def test_without_colours_marks_differ_in_shape(filled, monkeypatch):
    monkeypatch.setenv("NO_COLOR", "1")
    async with browsing(filled) as (app, _):
        assert app.no_color
        assert {"◆", "•"} <= set(shown(app))
        svg = app.export_screenshot().replace("#c5c8c6", "")  # colour of the screenshot's frame
        colours = set(re.findall(r"fill: (#\w{6})", svg))
        assert all(colour[1:3] == colour[3:5] == colour[5:7] for colour in colours)
