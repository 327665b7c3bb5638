"""The tool that alters the code: the mistakes it makes."""

from mutants import differs, mutants
from mutate import line_of, sample, wing_of

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


def test_mistakes_of_every_kind_are_made():
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
    assert len(constants) == 6  # none in docstrings, annotations, messages, __repr__


def test_changes_without_effect_are_not_made():
    for strict in (True, False):
        found = mutants("a.py", f"f = zip(a, b, strict={strict})\nassert f\n")
        assert {each.kind for each in found} == {"arguments swapped"}
    assert not mutants("a.py", 'T = TypeVar("T", bound=int, covariant=True)\n')
    kinds = {each.kind for each in mutants("a.py", "f = x in (a, b, 3)\n")}
    assert kinds == {"comparison", "constant"}  # but the order of members stays
    assert "values swapped" in {each.kind for each in mutants("a.py", "f = x == (a, b)\n")}


def test_a_mutant_knows_its_lines():
    limit, *_, last = mutants("package/a.py", SOURCE)
    assert (limit.first, limit.names) == (2, ("LIMIT",))
    assert (last.first, last.last, last.names, line_of(last, SOURCE)) == (10, 10, (), 10)
    wings = [wing_of(path) for path in ("orbitdb/store/a.py", "orbitdb/a.py", "cli/tui/a.py")]
    assert wings == ["store", "orbitdb", "cli"]


def test_a_sample_does_not_depend_on_changes_elsewhere():
    def chosen(source: str, seed: int) -> list[tuple[str, str]]:
        return [(each.kind, each.text) for each in sample(["a.py"], {"a.py": source}, 5, seed)]

    assert chosen(SOURCE, 3) == chosen("import math\n" + SOURCE, 3) != chosen(SOURCE, 4)
