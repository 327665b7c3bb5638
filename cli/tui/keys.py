"""The keys of all screens and widgets, grouped under headings; the help and docs/screen.md list them."""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial

from textual.binding import Binding, BindingType
from textual.keys import format_key

from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, REVERSE

Keys = Mapping[str, Sequence[Binding]]
"""Keys by heading. The help shows the tooltip of a key, or its description if it has no tooltip."""

Group = tuple[str, Sequence[tuple[str, str]]]
"""A heading, and pairs of a name and its meaning to list under it."""

_WORDS = ("enter", "escape", "backspace")

key = partial(Binding, show=False)
"""Make a binding that the footer does not show."""


def bindings(keys: Keys) -> list[BindingType]:
    """Return all keys as one list, for the `BINDINGS` of a screen or widget."""
    return [each for group in keys.values() for each in group]


def groups_of(parts: Iterable[Keys]) -> list[Group]:
    """Group the keys of widgets and screens by heading, each with what it does.

    The widgets and screens come in the order in which they receive keys.
    """
    groups: dict[str, dict[str, list[str]]] = {}
    heard: set[str] = set()
    for title, each in ((title, each) for keys in parts for title, group in keys.items() for each in group):
        new = [pressed for pressed in each.key.split(",") if pressed not in heard]
        heard.update(new)  # a key goes only to the first receiver that binds it
        if new and (told := each.tooltip or each.description):
            plain = [name if name in _WORDS else format_key(name) for name in new]
            names = [each.key_display] if each.key_display else plain
            groups.setdefault(title, {}).setdefault(told, []).extend(names)
    return [
        (title, [(" ".join(names), told) for told, names in group.items()]) for title, group in groups.items()
    ]


ORBITDB: Keys = {
    "orbitdb": [
        Binding("question_mark", "keys", "keys", tooltip="show this list of keys"),
        key("ctrl+p", "command_palette", tooltip="list all actions and themes"),
        Binding("q", "quit", "quit"),
        key("ctrl+q,ctrl+c", "quit"),
    ]
}

TABLE: Keys = {
    "moving": [
        key("j,down", "move(1)", "next row"),
        key("k,up", "move(-1)", "previous row"),
        key("pagedown,ctrl+f", "page(1)", "next page"),
        key("pageup,ctrl+b", "page(-1)", "previous page"),
        key("g,home", "first", "first row"),
        key("G,end", "last", "last row"),
        key("l,right", "shift(1)", "scroll right"),
        key("h,left", "shift(-1)", "scroll left"),
    ]
}


def _to(part: str, action: str) -> str:
    """Return the Textual action that runs `action` in a widget of the main screen."""
    return f"to({part!r}, {action!r})"


def _next(name: str, step: int = 1) -> str:
    """Return the Textual action that moves a criterion `step` values further."""
    return _to("chips", f"turn({name!r}, {step})")


MAIN: Keys = {
    "moving": [
        key("0", _to("position", "type(0)"), tooltip="go to a period or code", key_display="0 .. 9"),
        *(key(digit, _to("position", f"type({digit})")) for digit in "123456789"),
        key("backspace", _to("position", "take_back"), tooltip="delete the last digit"),
        Binding("c", _to("side", "code"), "code", tooltip="go to any code"),
        key("n", _to("table", "move(1)"), "show the next row's orbit"),
        key("p", _to("table", "move(-1)"), "show the previous row's orbit"),
    ],
    "symmetry class": [
        key("T,t", _to("side", f"move_in_class({REVERSE})"), "show the time reverse"),
        key("X,x", _to("side", f"move_in_class({MIRROR_X})"), "show the left-right mirror image"),
        key("Y", _to("side", f"move_in_class({MIRROR_Y})"), "show the up-down mirror image"),
        key("escape", "back", "go back to the row"),
    ],
    "looking": [
        key("enter", "whole", "show all facts, or go back"),
        key("space", _to("drawing", "particle"), "start or stop a particle"),
        Binding("v", _to("drawing", "view"), "view", tooltip="switch between stadium and phase space"),
        key("less_than_sign", _to("side", "follow(False)"), "follow the orbit to a smaller a"),
        key("greater_than_sign", _to("side", "follow(True)"), "follow the orbit to a larger a"),
        key("m", _to("side", "compare"), "add to or remove from the phase-space comparison"),
        key("M", _to("side", "compare_none"), "clear the comparison"),
        Binding("S", "statistics", "stats", tooltip="show averages by period"),
        Binding("d", "counts", "counts", tooltip="show counts and histograms"),
    ],
    "choosing": [
        Binding("slash", "filter", "filter", tooltip="filter the rows, as with --where"),
        key("o", _next("statuses"), "next status"),
        key("O", _to("chips", "statuses"), "choose statuses from a list"),
        key("r", _next("time_reversal"), "self-retracing orbits, time-reversed pairs, or all"),
        key("right_square_bracket", _next("periods"), "next period"),
        key("left_square_bracket", _next("periods", -1), "previous period"),
        key("a", "choose_a", "choose another a"),
        Binding("s", _to("rows", "sort"), "sort", tooltip="sort by a column"),
        key("R", _to("rows", "reverse_order"), "reverse the order"),
        key("C", _to("rows", "columns"), "choose columns"),
    ],
    "keeping": [
        key("asterisk", "mark", "mark or unmark the orbit"),
        key("apostrophe", _to("chips", "marked"), "show only marked orbits, or all"),
        key("F", _to("chips", "filters"), "use, save or delete named filters"),
        key("y", _to("side", "copy"), "copy the code"),
        Binding("e", "export", "export", tooltip="export to a file"),
    ],
    "orbitdb": [
        Binding("f", "fill", "fill", tooltip="fill the catalogue"),
        key("ctrl+r,f5", "look_again", "read the file again", key_display="ctrl+r"),
    ],
}

_RETURN = (
    Binding("escape", "dismiss", "back", tooltip="go back to the orbits"),
    key("q", "dismiss", tooltip="go back to the orbits"),
)

COUNTS: Keys = {
    "counts": [
        *_RETURN,
        key("d", "dismiss"),
        Binding("s", "column", "column", tooltip="choose another column"),
        Binding("right_square_bracket", "next_column(1)", "next column"),
        key("left_square_bracket", "next_column(-1)", "previous column"),
        Binding("e", "export", "export", tooltip="export the histogram as a figure"),
    ]
}

STATISTICS: Keys = {
    "statistics": [
        *_RETURN,
        Binding("w", "weight", "weight", tooltip="switch to the other weight"),
        Binding("e", "export", "export", tooltip="export the curves as a figure"),
        Binding("t", "trajectories", "trajectories", tooltip="follow more trajectories"),
    ]
}

SCROLLING: Keys = {
    "scrolling": [
        key("j,down", "scroll_down", "down"),
        key("k,up", "scroll_up", "up"),
        key("pagedown", "page_down", "next page"),
        key("pageup", "page_up", "previous page"),
        key("g,home", "scroll_home", "to the top"),
        key("G,end", "scroll_end", "to the end"),
        key("l,right", "scroll_right", "right"),
        key("h,left", "scroll_left", "left"),
    ]
}
