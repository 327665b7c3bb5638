"""The tool that alters the code: which mistakes it makes, and whether it tells who notices."""

from collections import Counter

import pytest
from mutants import differs, mutants
from mutate import sample
from verdicts import Verdict, of_the_wing, report

SOURCE = '''"""A package."""
LIMIT = 2.0  # of what is drawn

def inside(x: "int | None", y=1):
    """Tell 3 + 4 whether x < y."""
    if x is None and not y:
        raise ValueError("x - 1" + str(x))
    shown, hidden = x + 2 * y, [x for x in (x, y) if x > 0]
    hidden.append(shown)
    return draw(shown, limit=LIMIT)[1:]

class Drawn:
    def __repr__(self):
        return f"{1 + 1}" if 1 < 2 else ""
'''


def altered(kind: str) -> list[str]:
    found = [each for each in mutants("package/a.py", SOURCE) if each.kind == kind and differs(each, SOURCE)]
    return [each.shown(SOURCE)[1] for each in found]


def test_mistakes_of_every_kind():
    assert altered("border") == ["shown, hidden = x + 2 * y, [x for x in (x, y) if (x >= 0)]"]
    assert altered("comparison") == [
        "if (x is not None) and not y:",
        "shown, hidden = x + 2 * y, [x for x in (x, y) if (x <= 0)]",
    ]
    assert altered("condition dropped") == ["shown, hidden = x + 2 * y, [x for x in (x, y) if True]"]
    assert altered("and or") == ["if (x is None or not y):"]
    assert altered("negated") == ["if (not (x is None and (not y))):"]
    assert altered("sign") == ["if x is None and (y):"]
    assert altered("statement dropped") == ["pass", "pass"]
    assert altered("operator")[0] == "shown, hidden = (x - 2 * y), [x for x in (x, y) if x > 0]"
    assert len(altered("values swapped")) == 2
    assert altered("argument dropped") == ["return (draw(shown))[1:]"]
    constants = altered("constant")
    assert constants[:3] == ["LIMIT = 4.0  # of what is drawn", "LIMIT = 1.0  # of what is drawn",
                             'def inside(x: "int | None", y=2):']  # fmt: skip
    assert constants[-1] == "return draw(shown, limit=LIMIT)[2:]"
    assert len(constants) == 6  # none of docstrings, annotations, messages, __repr__


def test_assertions_are_left_alone():
    for strict in (True, False):
        found = mutants("a.py", f"f = zip(a, b, strict={strict})\nassert f\n")
        assert {each.kind for each in found} == {"arguments swapped"}


def test_what_makes_no_difference_is_left_alone():
    assert not mutants("a.py", 'T = TypeVar("T", bound=int, covariant=True)\n')
    kinds = [each.kind for each in mutants("a.py", "f = x in (a, b, 3)\n")]
    assert kinds == ["comparison", "constant"]  # but not the order of what x may be one of
    assert "values swapped" in {each.kind for each in mutants("a.py", "f = x == (a, b)\n")}


def test_where_there_is_no_mutant_it_is_told():
    assert report([], Counter()) == "there is nothing to alter"


def test_a_kind_counts_as_often_as_it_occurs():
    def verdict(kind: str, outcome: str) -> Verdict:
        return Verdict("store", "a.py", 1, kind, "", "", outcome, "", 1, 1, 0.0)

    told = [verdict("border", "survived"), verdict("border", "killed"), verdict("sign", "timed out")]
    population = Counter({("store", "border"): 10, ("store", "sign"): 90, ("cli", "sign"): 1000})
    assert of_the_wing(told, population) == pytest.approx(0.95)
    store, total = (line.split() for line in report(told, population).splitlines()[1:3])
    assert store[1:] == total[1:] == ["3", "1", "1", "1", "0", "67%", "95%"]


def test_a_mutant_knows_its_lines():
    limit, *_, last = mutants("package/a.py", SOURCE)
    assert (limit.first, limit.names) == (2, ("LIMIT",))
    assert (last.first, last.last, last.names, last.line(SOURCE)) == (10, 10, (), 10)


def test_a_sample_is_the_same_whatever_else_is_altered():
    more = {"a.py": SOURCE, "b.py": "x = 1\n"}
    chosen = sample(["a.py"], more, 5, seed=3)
    assert chosen == sample(["a.py"], more, 5, seed=3) != sample(["a.py"], more, 5, seed=4)
    below = sample(["a.py"], {"a.py": "import math\n" + SOURCE}, 5, seed=3)
    assert [(each.kind, each.text) for each in below] == [(each.kind, each.text) for each in chosen]
