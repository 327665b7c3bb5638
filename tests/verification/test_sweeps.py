"""Stored sweeps and births: complete periods are checked, whichever others are unfinished."""

import shutil
import sqlite3
import struct
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from contents import alter, ask, made
from solutions import representatives
from there import there

from orbitdb.billiard.stadium import Stadium
from orbitdb.filling.fill import fill_births, fill_periods
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.orbits.births import JOINTS
from orbitdb.orbits.solve import solve
from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.verification.check_births import births, check_births, lives, whole_births
from orbitdb.verification.check_sweeps import check_sweeps
from orbitdb.verification.checks import Check, Scope
from orbitdb.verification.verify import report, verify

BOTH = Selection(1.6), Selection(1.0)


@pytest.fixture(scope="module")
def swept_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("swept") / "orbits.db"
    return made(path, sweep_periods(path, 1.6, [4, 5]), sweep_periods(path, 1.0, [4]))


@pytest.fixture
def swept(swept_once: Path, tmp_path: Path) -> Callable[..., list[Check]]:
    """Return a function that alters p = 5 among sweeps of p = 4 and 5 at two a, and returns their checks."""
    path = tmp_path / "orbits.db"
    shutil.copy(swept_once, path)

    def found(change: str = "p = p", *values: object) -> list[Check]:
        with closing(sqlite3.connect(path)) as plain, plain:
            plain.execute(f"UPDATE sweep SET {change} WHERE p = 5", values)
        with reading(path) as connection:
            return list(check_sweeps(Scope(connection, BOTH)))

    return found


def failures(checks: list[Check]) -> list[tuple[str, str | None]]:
    return [(check.name, check.first) for check in checks if check.failures]


def test_sound_sweeps_pass_and_are_counted_once(swept):
    found = swept()
    assert not failures(found)
    assert [sum(check.rows for check in found if check.name == name) for name in ("sweeps", "sums")] == [3, 3]
    (only,) = {check.name: check for check in found if check.name == "sums"}.values()
    assert 0 <= only.share < 0.5


@pytest.mark.parametrize(
    ("change", "first"),
    [
        ("n_c = n_c - 2", "n_c is 78 instead of 80"),
        ("classes = classes - 1", "classes is 14 instead of 15"),
        ("boundary = 2", "boundary is 2 instead of 0"),
        ("unresolved = 1", "unresolved is 1 instead of 0"),
        ("words = words - 2", "94 words instead of 96"),
    ],
)
def test_impossible_counts_are_found(swept, change, first):
    assert failures(swept(change))[0] == ("sweeps", f"p = 5 at a = 1.6: {first}")


def test_sums_without_ranges_are_found(swept):
    found = swept("sums = substr(sums, 1 + 8 * 2 * 3)")  # of three measures
    assert failures(found) == [("sums", "p = 5 at a = 1.6")]


def test_sums_agree_with_new_solutions_up_to_rounding(swept, tmp_path):
    with closing(sqlite3.connect(tmp_path / "orbits.db")) as plain:
        ((blob,),) = plain.execute("SELECT sums FROM sweep WHERE p = 5 AND sums NOT NULL").fetchall()
    *rest, last = struct.unpack(f"<{len(blob) // 8}d", blob)
    orbits = solve(representatives(5), Stadium(1.6))
    orbits = orbits.rows(orbits.status == "orbit")
    loose = (orbits.lyapunov_error + orbits.length_error / orbits.length).max()
    for off, share in ((4e-13, 0.4), (1e-9, 1000)):
        found = swept("sums = ?", struct.pack(f"<{len(blob) // 8}d", *rest, last * (1 + off)))
        sums = [check for check in found if check.name == "sums"][1]
        assert sums.share == pytest.approx(share, rel=0.4)
        assert sums.worst / sums.share == pytest.approx(1e-12 + 20 * loose, rel=1e-9, abs=0)
        assert failures(found) == ([("sums", "p = 5 at a = 1.6")] if share > 1 else [])


@pytest.mark.parametrize(
    "fill", [lambda path: fill_periods(path, 1.6, [5]), lambda path: fill_births(path, [5])]
)
def test_counts_of_fills_and_of_births_are_compared(swept, fill, tmp_path):
    list(fill(tmp_path / "orbits.db"))
    assert not failures(swept())
    alter(
        tmp_path / "orbits.db",
        "UPDATE fill SET n_c = 82",
        "UPDATE change SET a = 3 WHERE cycle = (SELECT max(cycle) FROM change)",
    )
    assert there(failures(swept())[0][1]).startswith("p = 5 at a = 1.6: n_c is 80 instead of ")


@pytest.fixture(scope="module")
def begun_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("begun") / "orbits.db"
    made(path, fill_births(path, [4, 5]))
    alter(path, "UPDATE birth_fill SET state = 'filling' WHERE p = 4")
    return path


@pytest.fixture
def begun(begun_once: Path, tmp_path: Path) -> Path:
    """A catalogue with the births of p = 5, and with those of p = 4 unfinished."""
    return Path(shutil.copy(begun_once, tmp_path / "orbits.db"))


@pytest.mark.parametrize(
    "change", ["bounce = 1 + bounce % 5", f"joint = iif(joint = '{JOINTS[0]}', '{JOINTS[1]}', '{JOINTS[0]}')"]
)
def test_a_birth_at_another_bounce_or_joint_is_found(begun, change):
    last = "(SELECT max(cycle) FROM change WHERE a > 0)"
    ((word,),) = ask(begun, f"SELECT word FROM cycle WHERE id = {last}")
    alter(begun, f"UPDATE change SET {change} WHERE cycle = {last}")
    with reading(begun) as connection:
        scope = Scope(connection)
        found = [check for part in births(scope) for check in part.checked(scope).checks]
    ((name, first),) = failures(found)
    assert (name, there(first).partition(" ")[0]) == ("births", word)


@pytest.mark.slow
def test_an_unfinished_period_does_not_hide_later_ones(begun):
    list(fill_periods(begun, 1.6, [5]))
    alter(begun, "UPDATE fill SET state = 'filling', n_c = NULL")
    with reading(begun) as connection:
        scope = Scope(connection)
        steps = [part.checked(scope) for part in lives(scope, 12)]
        assert [(step.stage, step.done, step.total) for step in steps] == [
            ("missing births, p = 5", 12, 17),
            ("missing births, p = 5", 17, 17),
        ]
        assert [(c.name, c.rows, c.failures) for step in steps for c in step.checks] == [
            ("lives", 12, 0),
            ("lives", 5, 0),
        ]
        (found,) = check_births(scope)
        assert (found.rows, found.failures) == (17, 0)


@pytest.mark.slow
def test_only_births_of_chosen_periods_are_checked(begun):
    list(fill_births(begun, [6]))
    for chosen, expected in (
        ((), [5, 6]),
        ((Selection.from_criteria(p=6),), [6]),
        ((Selection.from_criteria(p=7), Selection.from_criteria(a=1, p="4-5")), [5]),
    ):
        with reading(begun) as connection:
            assert [found.p for found in whole_births(Scope(connection, chosen))] == expected
    with reading(begun) as connection:
        found = report(verify(connection, [Selection.from_criteria(p=5)], missing_births=True))
        counted = {check.name: check.rows for check in found}
    assert (counted["births"], counted["lives"]) == (17, 17)


@pytest.mark.slow
def test_births_and_deaths_must_alternate_and_give_the_counts(begun):
    """A rebirth is made by hand, because only longer words die and are reborn, such as some of p = 9."""

    def failing(*statements: str) -> str | None:
        alter(begun, *statements)
        with reading(begun) as connection:
            (check,) = check_births(Scope(connection))
        return check.first

    insert = "INSERT INTO change SELECT cycle, {}, {} * a, error, '{}', bounce, joint, NULL, slope, run"
    where = "FROM change WHERE a = (SELECT min(a) FROM change WHERE a > 0) AND number = 1 LIMIT 1"
    added = [f"{insert.format(*values)} {where}" for values in ((2, 1.1, "died"), (3, 1.2, "born"))]
    assert failing(*added) == "p = 5: births is 13 instead of 14"
    assert failing("UPDATE birth_fill SET births = 14, deaths = 1 WHERE p = 5") is not None  # the events
    same = "FROM change AS b JOIN cycle ON id = b.cycle WHERE p = 5 AND 0 < b.a AND b.a <= change.a + 1e-9"
    of_five = "cycle IN (SELECT id FROM cycle WHERE p = 5)"
    renumber = f"(SELECT count(DISTINCT round(b.a, 9)) {same}) WHERE a > 0 AND {of_five}"
    assert failing(f"UPDATE change SET event = {renumber}") is None
    for name in ("classes", "births", "deaths", "always", "least", "largest"):
        first = failing(f"UPDATE birth_fill SET {name} = 2 * {name} WHERE p = 5")
        assert there(first).startswith(f"p = 5: {name} is ")
        failing(f"UPDATE birth_fill SET {name} = {name} / 2 WHERE p = 5")
    for wrong, right in (
        ("number = 4 WHERE number = 3", "number = 3 WHERE number = 4"),
        ("kind = 'died' WHERE number = 3", "kind = 'born' WHERE number = 3"),
        ("error = 2 * a WHERE number = 2", "error = 0 WHERE number = 2"),
    ):
        assert failing(f"UPDATE change SET {wrong}") is not None
        assert failing(f"UPDATE change SET {right}") is None
