"""Text can be read in every theme, pruned words are dimmer than orbits, and curves differ in colour."""

import itertools
import re
from typing import Any

import pytest
from contrasts import texts_of
from screens import browsing, press
from textual.color import Color
from textual.theme import BUILTIN_THEMES

from orbitdb.cli.tui.colours import TEXT, contrast, readable, readable_variables
from orbitdb.cli.tui.panels.canvas import Plot
from orbitdb.cli.tui.panels.paged_table import PagedTable
from orbitdb.cli.tui.screens import Dialog
from orbitdb.selection import Selection

THEMES = [name for name in BUILTIN_THEMES if not name.startswith("ansi")]
INKS = ("one", "two", "three", "four", "five", "six")


@pytest.mark.parametrize(
    ("one", "other", "known"),
    [
        ("#ffffff", "#000000", 21),
        ("#777777", "#ffffff", 4.48),
        ("#0000ff", "#ffffff", 8.59),
        ("#ff0000", "#ffffff", 4.0),
        ("#0178d4", "#0178d4", 1),
    ],
)
def test_contrasts_are_those_of_wcag(one, other, known):
    """The values are those of WebAIM's contrast checker."""
    colours = Color.parse(one), Color.parse(other)
    assert contrast(*colours) == contrast(*colours[::-1]) == pytest.approx(known, abs=0.005)


def test_a_readable_colour_stays_as_it_is_and_others_change_no_more_than_needed():
    white = Color.parse("#ffffff")
    assert readable(Color.parse("#555555"), [white]) == Color.parse("#555555")
    changed = readable(Color.parse("#ffa62b"), [white])
    assert TEXT <= contrast(changed, white) < TEXT + 1
    assert changed.r > changed.g > changed.b  # still orange


@pytest.mark.parametrize("name", THEMES)
def test_the_colours_of_every_theme_can_be_read(name):
    theme = BUILTIN_THEMES[name]
    variables = readable_variables({**theme.to_color_system().generate(), **theme.variables})

    def colour(each):
        return Color.parse(variables[each])

    grounds = [colour(each) for each in ("background", "surface", "panel")]
    for each in ("foreground", "muted", "key", "text-error", "text-warning"):
        assert min(contrast(colour(each), ground) for ground in grounds) >= TEXT, each
    for each in ("block-cursor", "block-cursor-blurred", "input-selection"):
        assert contrast(colour(f"{each}-foreground"), colour(f"{each}-background")) >= TEXT, each
    assert contrast(colour("footer-key-foreground"), colour("footer-background")) >= TEXT
    assert min(contrast(colour(f"ink-{ink}"), grounds[0]) for ink in INKS) >= TEXT  # on the background only
    clear, dim = (contrast(colour(each), grounds[0]) for each in ("foreground", "muted"))
    assert clear > 1.2 * dim
    for one, other in itertools.combinations((colour(f"ink-{ink}") for ink in INKS), 2):
        assert sum(abs(x - y) for x, y in zip(one.rgb, other.rgb, strict=True)) > 60


def unreadable(app):
    """Return the texts with too little contrast; only a dialog counts, if one is open."""
    boxes = [box.region for box in app.screen.query(".dialog")] if isinstance(app.screen, Dialog) else []
    return [
        (cells.text, round(cells.contrast, 2), cells.ink.hex, cells.ground.hex)
        for cells in texts_of(app)
        if cells.contrast < TEXT and all(box.contains(cells.x, cells.y) for box in boxes)
    ]


async def with_theme(app, pilot, name):
    app.theme = name
    await press(pilot)
    await pilot.pause()


@pytest.mark.slow
async def test_pruned_words_are_dimmer_than_orbits(filled_once):
    some = Selection(where="p in (5, 6) and code like '0113%'")
    async with browsing(filled_once, (110, 40), some) as (app, pilot):
        for name in THEMES:
            await with_theme(app, pilot, name)
            assert unreadable(app) == [], name
            table, found = app.screen.query_one(PagedTable), dict[str, Any]()
            place = table.content_region.y + table.cursor + 1 - table.scroll_offset.y
            for cells in texts_of(app):
                status = re.search("orbit|dynamical", cells.text)
                if table.region.contains(cells.x, cells.y) and status and cells.y != place:
                    found.setdefault(status[0], set()).add(cells.contrast)
            (clear,), (dim,) = found["orbit"], found["dynamical"]
            assert clear > 1.2 * dim, name


KEYS = "slash,l,e", "slash,l,e,x", "f", "O", "C", "d", "S", "question_mark", "enter", "v", "c", "E", "G,o,o"
FEW = ["textual-dark", "textual-light", "solarized-light"]


@pytest.mark.slow
@pytest.mark.parametrize("keys", KEYS)
@pytest.mark.parametrize("names", [FEW, pytest.param(THEMES, marks=pytest.mark.fuzz)])
async def test_every_screen_and_dialog_can_be_read(filled_once, keys, names):
    async with browsing(filled_once, (120, 44)) as (app, pilot):
        await press(pilot, *keys.split(","))
        for name in names:
            await with_theme(app, pilot, name)
            assert unreadable(app) == [], name


@pytest.mark.slow
async def test_each_curve_has_an_ink_of_its_own(filled_once):
    async with browsing(filled_once, (160, 48)) as (app, pilot):
        await press(pilot, "S")
        for plot in app.screen.query(Plot):
            styles = [curve.style for curve in plot.curves if curve.name]
            assert len(set(styles)) == len(styles) > 2
