"""Texts of dialogs and notifications are never cut off, even on small terminals."""

import gc

import pytest
from screens import SMALL, TINY, browsing, press, screen_lines, shown, write
from textual._styles_cache import StylesCache
from textual.widget import Widget
from textual.widgets import Button, Label
from textual.widgets._toast import Toast

from orbitdb.cli.tui.dialogs import LineDialog
from orbitdb.cli.tui.fill_dialog import FillRequest, FillState
from orbitdb.cli.tui.help import PURPOSES, explained
from orbitdb.selection import Selection

pytestmark = pytest.mark.slow

LONG_PATH = "/a" * 120


def squeezed(text):
    return "".join(text.split())


def seen(app, region):
    """Return the text visible in a region, without blanks, because lines may be wrapped."""
    lines = screen_lines(app)[max(region.y, 0) : region.bottom]
    return squeezed("".join(line[max(region.x, 0) : region.right] for line in lines))


def cut_off(app):
    """Return the texts of the open dialog that are not fully visible."""
    shown = [
        label for label in app.screen.query(Label) if all(node.display for node in label.ancestors_with_self)
    ]
    texts = [(str(label.render()), label.region) for label in shown]
    texts += [(each.label.plain, each.region) for each in app.screen.query(Button) if each.display]
    for box in app.screen.query(".dialog"):
        texts += [(title, box.region) for title in (box.border_title, box.border_subtitle) if title]
    return [text for text, region in texts if squeezed(text) not in seen(app, region)]


RUNNING = FillState(FillRequest(1.6, (13,)), done=123_456)
DIALOGS = [
    ("q", "", ""), ("f", "", ""),  # while a fill runs
    ("f", "2-14", "enter"), ("slash", "lenght < 3", ""), ("c", "1232131" * 9 + "9", ""),
    ("e", "HERE/there.csv", ""), ("C", "", ""), ("f", "2-20", "tab"),
]  # fmt: skip
"""The key that opens a dialog, the text for its field, and a key that follows."""


async def test_dialogs_are_fully_visible(filled, monkeypatch):
    filled.with_name("there.csv").touch()
    async with browsing(filled, TINY) as (app, pilot):
        for key, text, then in DIALOGS:
            app.fill_state = RUNNING if key in "qf" and not text else None
            if text == "2-20":
                monkeypatch.setattr("orbitdb.filling.estimate.BYTES", 1e12)
            await press(pilot, key)
            if text:
                there, field = text.replace("HERE", str(filled.parent)), "#periods" if key == "f" else "Input"
                await write(pilot, there, *then.split(), field=field)
            assert app.screen.query(".dialog"), key
            assert ("no room" in shown(app)) == (text == "2-20")
            if key == "f" and then != "enter":  # the dialog asks for confirmation
                buttons = [(each.display, each.has_focus) for each in app.screen.query(Button)]
                assert buttons == [(bool(text), False), (not text, not text)]
                assert app.screen.query_one("#cost").display == bool(text)
                assert text or "filling 0:" in shown(app)
            assert cut_off(app) == [], (key, text)
            app.fill_state = None
            while len(app.screen_stack) > 1:
                await press(pilot, "escape")


@pytest.mark.parametrize("key", ["", "enter", "d", "S"])
async def test_every_key_that_works_is_on_the_page_of_keys(filled, key):
    async with browsing(filled, TINY, Selection(periods=((2, 3),))) as (app, pilot):
        await press(pilot, *filter(None, [key]))
        screen = app.screen
        active = [*screen.active_bindings.values()]
        await press(pilot, "question_mark")
        text = str(app.screen.query_one("#keys Static").content)
        for each in active:
            ours = each.binding.id in PURPOSES and each.enabled and not each.binding.system
            assert not ours or f"{app.get_key_display(each.binding)}" in text, each
            assert not ours or explained(each.binding) in text
        assert "PageLeft" not in text  # a key of Textual's own
        await press(pilot, "question_mark")
        assert app.screen is screen


async def test_the_page_of_keys_scrolls_and_can_be_searched(filled):
    async with browsing(filled, TINY) as (app, pilot):
        main = app.screen
        await press(pilot, "question_mark")
        assert "next row" in shown(app)
        assert "fill the catalogue" not in shown(app).splitlines()[-2]
        await press(pilot, "G")
        assert "list all actions by name" in shown(app)
        await press(pilot, "slash", *"birth")
        text = shown(app)
        assert "follow it up to a birth or death" in text
        assert "next row" not in text
        await press(pilot, *"xyz")
        assert "no key does that" in shown(app)
        await press(pilot, "escape")
        assert "next row" in shown(app)
        await press(pilot, "escape")
        assert app.screen is main


async def test_a_closed_dialog_leaves_no_widgets_and_no_drawn_lines(filled):
    """What stays of each would add up to megabytes in a long session."""
    async with browsing(filled) as (app, pilot):
        keys = ("question_mark", "f", "slash", "C", "O", "c", "E", "d", "S", "e", "ctrl+p")
        totals = []
        for _ in range(4):
            for key in keys:
                await press(pilot, key, "escape")
            gc.collect()
            totals.append(sum(isinstance(each, (Widget, StylesCache)) for each in gc.get_objects()))
        assert app.screen is app.screen_stack[0]
        assert totals[3] - totals[1] < 25  # the last one may still be there


async def test_escape_and_the_next_key_may_arrive_as_one(filled):
    """Within tmux, `escape` and a letter are the letter with Alt."""
    async with browsing(filled) as (app, pilot):
        await press(pilot, "question_mark", "alt+c")
        assert isinstance(app.screen, LineDialog)
        await press(pilot, "escape", "slash", *"p<3", "alt+q")
        assert app.screen is app.screen_stack[0]
        assert app.is_running


@pytest.mark.parametrize("size", [SMALL, TINY])
async def test_notifications_are_fully_visible(filled, size):
    async with browsing(filled, size, notifications=True) as (app, pilot):
        message = f"{LONG_PATH} is read-only: copy it, or name another file with --db, " + "and so on, " * 20
        app.notify(message)
        await pilot.pause()
        await pilot.pause()
        assert squeezed(message) in seen(app, app.screen.query_one(Toast).content_region)
