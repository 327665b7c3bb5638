"""What is chosen, in words and links, and how each choice goes on."""

import re

import pytest

from orbitdb.cli.tui import choices
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.criteria import choose
from orbitdb.store.asking.selection import Selection


def test_choices_go_round():
    chosen, seen = Selection(), []
    for _ in range(6):
        chosen = choices.turned(chosen, "statuses", choices.STATUSES)
        seen.append(chosen.statuses)
    assert seen == [(Status.ORBIT,), (Status.DYNAMICAL,), (Status.BOUNDARY,), (Status.GEOMETRIC,),
                    (Status.UNRESOLVED,), ()]  # fmt: skip
    several = Selection(statuses=(Status.ORBIT, Status.BOUNDARY))
    assert choices.turned(several, "statuses", choices.STATUSES).statuses == (Status.ORBIT,)
    for reversal in ("self", "pair", None):
        chosen = choices.turned(chosen, "time_reversal", choices.REVERSALS)
        assert chosen.time_reversal == reversal
    ring = ((), ((2, 2),), ((4, 4),), ((5, 5),))
    for step, periods in ((1, [2, 4, 5]), (-1, [5, 4, 2])):
        for p in periods:
            chosen = choices.turned(chosen, "periods", ring, step)
            assert chosen.periods == ((p, p),)
        chosen = choices.turned(chosen, "periods", ring, step)
        assert chosen.periods == ()
    for others in (((2, 4), (5, 5)), ((3, 3),)):  # none of the periods alone
        assert choices.turned(Selection(periods=others), "periods", ring).periods == ((2, 2),)


def test_choices_are_links_to_what_changes_them():
    plain = choices.chips(Selection(), 1)
    assert re.sub(r"\[@click=screen\.([^\]]*)\]|\[/\]", "", plain) == (
        "a = 1.6 │ p all │ every status │ any reversal │ no filter"
    )
    statuses = (Status.ORBIT, Status.BOUNDARY)
    chosen = Selection(1.0, ((2, 4), (7, 7)), statuses, "self", where="code like '[1]'")
    links = re.findall(r"\[@click=screen\.([^\]]*)\](.*?)\[/\]", choices.chips(chosen, 2))
    assert links == [
        ("choose_a", "a = 1 of 2"), ("period(1)", "p 2-4, 7"), ("status", "orbit, boundary"),
        ("reversal", "self-retracing"), ("filter", r"where code like '\[1]'"),
    ]  # fmt: skip


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
def test_choices_without_a_field_of_their_own_stand_at_the_end(chosen, told):
    shown = choices.chips(choose(**chosen), 1)
    assert shown.endswith(f"[@click=screen.filter]{told}[/]")
