"""What the help shows: the keys of a screen in groups."""

from collections.abc import Sequence

from textual.screen import Screen

Group = tuple[str, Sequence[tuple[str, str]]]

MAIN: tuple[Group, ...] = (
    ("moving", (
        ("j k ↓ ↑", "next row, row before"),
        ("pgdn pgup", "a page"),
        ("g G", "first row, last row"),
        ("h l ← →", "more columns"),
        ("c", "go to a code, in any rotation"),
    )),
    ("the class of the orbit", (
        ("T", "time reverse"),
        ("X", "mirror left and right"),
        ("Y", "mirror up and down"),
        ("escape", "back to the row"),
    )),
    ("looking", (
        ("space", "send a particle along, stop it"),
        ("v", "stadium or phase space"),
        ("m M", "mark to compare, unmark all"),
        ("S", "statistics of the subset"),
    )),
    ("choosing", (
        ("/", "filter, as in --where"),
        ("o", "status: all, orbits, pruned .."),
        ("r", "self-retracing, others, all"),
        ("[ ]", "period"),
        ("a", "another stadium"),
        ("s", "sort by a column"),
        ("R", "turn the order round"),
    )),
    ("taking away", (
        ("y", "copy the word"),
        ("e", "export rows or picture"),
    )),
    ("orbitdb", (
        ("f", "fill the catalogue"),
        ("ctrl+p", "every action, themes"),
        ("q", "quit"),
    )),
)  # fmt: skip

STATISTICS: tuple[Group, ...] = (
    ("statistics", (
        ("j k ↓ ↑", "scroll the numbers"),
        ("w", "weight: e^-λ or 1/|det(1 - M)|"),
        ("t", "follow the trajectories again"),
        ("escape q", "back to the orbits"),
    )),
    ("orbitdb", (("ctrl+p", "every action, themes"), ("?", "these keys"))),
)  # fmt: skip


def groups_for(screen: Screen[object]) -> Sequence[Group]:
    """Return the keys that matter on a screen."""
    return STATISTICS if type(screen).__name__ == "StatisticsScreen" else MAIN
