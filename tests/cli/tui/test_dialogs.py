"""No text of a dialog or of a notification is cut off, on small terminals either."""

import pytest
from screens import SMALL, TINY, drive, press, screen_lines, settle
from textual.widgets import Button, Label
from textual.widgets._toast import Toast

from orbitdb.cli.tui.dialogs.keys import KeysDialog
from orbitdb.store.asking.selection import Selection

LONG_PATH = "/a" * 120


def squeezed(text):
    return "".join(text.split())


def seen(app, region):
    """Return what is to be seen in a region, without blanks: texts may be folded."""
    lines = screen_lines(app)[max(region.y, 0) : region.bottom]
    return squeezed("".join(line[max(region.x, 0) : region.right] for line in lines))


def cut_off(app):
    """Return the texts of the dialog that is open of which a part cannot be seen."""
    shown = [
        label for label in app.screen.query(Label) if all(node.display for node in label.ancestors_with_self)
    ]
    texts = [(str(label.render()), label.region) for label in shown]
    texts += [(button.label.plain, button.region) for button in app.screen.query(Button)]
    for box in app.screen.query(".dialog"):
        texts += [(title, box.region) for title in (box.border_title, box.border_subtitle) if title]
    return [text for text, region in texts if squeezed(text) not in seen(app, region)]


DIALOGS = [
    quit_question, fill_that_runs, fill_without_room, long_fill, wrong_filter, wrong_code,
    export_over_a_file, sorting, choosing_columns, kept_filters,
]  # fmt: skip


@pytest.mark.slow
def test_dialogs_are_wholly_visible(filled):
    filled.with_name("there.csv").touch()

    async def steps(app, pilot):
        for opened in DIALOGS:
            await opened(app, pilot)
            await pilot.pause()
            assert app.screen.query(".dialog"), opened.__name__
            assert cut_off(app) == [], opened.__name__
            app.fill_state = None
            while len(app.screen_stack) > 1:
                await press(pilot, "escape")

    drive(filled, steps, TINY)


@pytest.mark.slow
@pytest.mark.parametrize("key", ["question_mark", "S"])
def test_keys_are_wholly_readable(filled, key):
    async def steps(app, pilot):
        await press(pilot, *dict.fromkeys((key, "question_mark")))
        assert isinstance(app.screen, KeysDialog)
        await pilot.resize_terminal(TINY[0], 60)  # where there are fewer rows, they are scrolled
        await settle(pilot)
        text = seen(app, app.screen.region)
        for _, keys in app.screen.groups:
            for name, meaning in keys:
                assert squeezed(name) in text
                assert all(word in text for word in meaning.split())

    drive(filled, steps, TINY, Selection(periods=((2, 3),)))


@pytest.mark.slow
@pytest.mark.parametrize("size", [SMALL, TINY])
def test_notifications_are_wholly_visible(filled, size):
    async def steps(app, pilot):
        message = f"{LONG_PATH} is read-only: copy it, or name another file with --db, " + "and so on, " * 20
        app.notify(message)
        await pilot.pause()
        await pilot.pause()
        assert squeezed(message) in seen(app, app.screen.query_one(Toast).content_region)

    drive(filled, steps, size, notifications=True)
