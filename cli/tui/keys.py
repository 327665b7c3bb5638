"""What the help shows: the keys of a screen in groups, and what the columns of its table are."""

from collections.abc import Sequence

from textual.screen import Screen

from orbitdb.cli.tui.dialogs.basic import Group
from orbitdb.cli.tui.table.columns import COLUMNS
from orbitdb.columns import IN_CATALOGUE, Column

MAIN: tuple[Group, ...] = (
    ("moving", (
        ("j k ↓ ↑", "row by row"),
        ("pgdn pgup", "a page"),
        ("g G", "first, last row"),
        ("h l ← →", "more columns"),
        ("0 .. 9", "period or code"),
        ("c", "any code, solved"),
    )),
    ("its symmetry class", (
        ("T", "time reverse"),
        ("X", "mirror left, right"),
        ("Y", "mirror up, down"),
        ("escape", "back to the row"),
    )),
    ("looking", (
        ("enter", "the whole orbit"),
        ("space", "run a particle"),
        ("v", "phase space"),
        ("< >", "follow it in a"),
        ("m M", "compare, none"),
        ("S", "statistics"),
        ("d", "counts, histogram"),
    )),
    ("choosing", (
        ("/", "filter (--where)"),
        ("o O", "status; from a list"),
        ("r", "self-retracing .."),
        ("[ ]", "period"),
        ("a", "another a"),
        ("s", "sort"),
        ("R", "turn the order"),
        ("C", "columns"),
    )),
    ("keeping", (
        ("*", "mark, unmark"),
        ("'", "marked orbits only"),
        ("F", "filters by name"),
        ("y", "copy the word"),
        ("e", "export to a file"),
    )),
    ("orbitdb", (
        ("f", "fill the catalogue"),
        ("ctrl+r", "read the file again"),
        ("ctrl+p", "all actions, themes"),
        ("q", "quit"),
    )),
)  # fmt: skip

STATISTICS: tuple[Group, ...] = (
    ("statistics", (
        ("j k ↓ ↑", "scroll the numbers"),
        ("w", "weight: e^-λ or 1/|det(1 - M)|"),
        ("t", "follow more trajectories; the better value stays"),
        ("escape q", "back to the orbits"),
    )),
    ("orbitdb", (("ctrl+p", "all actions, themes"), ("?", "these keys"))),
)  # fmt: skip

COUNTS: tuple[Group, ...] = (
    ("counts", (
        ("j k ↓ ↑", "scroll the counts"),
        ("s", "histogram of another column"),
        ("[ ]", "the column before, the next"),
        ("escape q", "back to the orbits"),
    )),
    ("orbitdb", (("ctrl+p", "all actions, themes"), ("?", "these keys"))),
)  # fmt: skip

WHOLE: tuple[Group, ...] = (
    ("the whole orbit", (
        ("j k ↓ ↑", "line by line"),
        ("pgdn pgup", "a page"),
        ("g G", "top, end"),
        ("space", "run a particle"),
        ("v", "phase space"),
        ("escape q", "back to the orbits"),
    )),
    ("orbitdb", (("ctrl+p", "all actions, themes"), ("?", "these keys"))),
)  # fmt: skip

_ELSEWHERE = {"StatisticsScreen": STATISTICS, "WholeOrbitScreen": WHOLE, "CountsScreen": COUNTS}


def groups_for(screen: Screen[object]) -> Sequence[Group]:
    """Return the keys that matter on a screen."""
    return _ELSEWHERE.get(type(screen).__name__, MAIN)


def columns_for(screen: Screen[object]) -> Group | None:
    """Return what the columns are that a filter may name, with the heading of those that have another."""
    if type(screen).__name__ in _ELSEWHERE:
        return None
    headings = {column.name: column.heading for column in COLUMNS}
    return "columns, as a filter names them", [
        (" ".join(dict.fromkeys((each.name, headings.get(each.name, each.name)))), _told(each))
        for each in IN_CATALOGUE
    ]


def _told(column: Column) -> str:
    """Say in one line what a column holds."""
    unit = f" ({column.unit})" if column.unit not in ("", "1") else ""
    bound = f", ± {column.bound}" if column.bound.endswith("_error") else ""
    return f"{column.brief}{unit}{bound}"
