"""The keys of the main screen, and those that several screens share.

The help of Textual shows the description of a key, then its tooltip; the footer shows the description.
"""

from functools import partial

from textual.binding import Binding, BindingType

from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, REVERSE

key = partial(Binding, show=False)
"""Make a binding that the footer does not show."""

SCROLLING: list[BindingType] = [
    key("j,down", "scroll_down", "down"),
    key("k,up", "scroll_up", "up"),
    key("pagedown", "page_down", "next page"),
    key("pageup", "page_up", "previous page"),
    key("g,home", "scroll_home", "to the top"),
    key("G,end", "scroll_end", "to the end"),
    key("l,right", "scroll_right", "right"),
    key("h,left", "scroll_left", "left"),
]

LEAVING: list[BindingType] = [
    Binding("escape", "dismiss", "back", tooltip="to the orbits"),
    key("q", "dismiss", "back", tooltip="to the orbits"),
]


def _to(part: str, action: str) -> str:
    return f"to({part!r}, {action!r})"


MAIN: list[BindingType] = [
    key("0", "digit('0')", "go to", tooltip="a period or code", key_display="0 .. 9"),
    *(key(digit, f"digit({digit!r})", system=True) for digit in "123456789"),
    key("backspace", _to("position", "take_back"), "delete", tooltip="the last digit"),
    Binding("c", _to("side", "code"), "code", tooltip="in any rotation, stored or not"),
    key("enter", "whole", "all facts", tooltip="about the orbit, or back"),
    Binding("q", "leave_whole", "back", tooltip="to the rows"),
    key("n", _to("table", "move(1)"), "next orbit"),
    key("p", _to("table", "move(-1)"), "previous orbit"),
    key("T,t", _to("side", f"move_in_class({REVERSE})"), "time reverse"),
    key("X,x", _to("side", f"move_in_class({MIRROR_X})"), "left-right mirror image"),
    key("Y", _to("side", f"move_in_class({MIRROR_Y})"), "up-down mirror image"),
    key("escape", "back", "back", tooltip="to the row"),
    key("space", _to("drawing", "particle"), "particle", tooltip="starts or stops"),
    Binding("v", _to("drawing", "view"), "view", tooltip="stadium or phase space"),
    key("less_than_sign", _to("side", "follow(False)"), "smaller a", tooltip="for this orbit"),
    key("greater_than_sign", _to("side", "follow(True)"), "larger a", tooltip="for this orbit"),
    key("comma", _to("side", "follow(False, True)"), "birth or death", tooltip="at the next smaller a"),
    key("full_stop", _to("side", "follow(True, True)"), "birth or death", tooltip="at the next larger a"),
    Binding("slash", "filter", "filter", tooltip="the rows, as with --where"),
    key("equals_sign", "filter_value", "filter", tooltip="by the value under the cursor"),
    key("u", "past_view", "undo", tooltip="the last filter, order, columns or a"),
    key("o", _to("chips", "turn('statuses', 1)"), "next status"),
    key("O", _to("chips", "statuses"), "choose statuses", tooltip="from a list"),
    key("r", _to("chips", "turn('time_reversal', 1)"), "time reversal", tooltip="self, pairs or all"),
    key("right_square_bracket", _to("chips", "turn('periods', 1)"), "next period"),
    key("left_square_bracket", _to("chips", "turn('periods', -1)"), "previous period"),
    key("a", "choose_a", "another a"),
    Binding("s", _to("rows", "sort"), "sort", tooltip="by a column"),
    key("R", _to("rows", "reverse_order"), "reverse the order"),
    key("C", _to("rows", "columns"), "choose columns"),
    Binding("S", "statistics", "stats", tooltip="by period"),
    Binding("d", "counts", "counts", tooltip="and histograms"),
    key("asterisk", "mark", "mark", tooltip="the orbit, or remove its mark"),
    key("apostrophe", _to("chips", "marked"), "marked orbits", tooltip="only, or all"),
    key("y", _to("side", "copy"), "copy", tooltip="the code"),
    key("E", "copy_view", "copy", tooltip="the view as a command or in Python"),
    Binding("e", "export", "export", tooltip="to a file"),
    Binding("f", "fill", "fill", tooltip="the catalogue"),
    key("ctrl+r,f5", "look_again", "reload", tooltip="the file"),
]
