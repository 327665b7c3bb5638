"""Verification passes a sound catalogue and finds whatever is altered by hand."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from contents import alter, ask, checks
from there import there

from orbitdb.catalogue import Catalogue
from orbitdb.errors import StoreError
from orbitdb.filling.fill import fill_periods
from orbitdb.filling.workers import Processes
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.store.file import migrate, reading
from orbitdb.verification.check_classes import classes
from orbitdb.verification.checks import Check, Scope, blocks, checked_apart
from orbitdb.verification.verify import PROMISES, orbits, verify

SEQUENCES, CLASSES = 3197, 498  # p = 2..8


def broken(path: Path, **options) -> set[str]:
    return {name for name, check in checks(path, **options).items() if check.failures}


def test_a_sound_catalogue_passes_every_check(filled):
    found = checks(filled, restarts=2)
    assert {name for name, check in found.items() if check.failures} == set()
    others = {"certificates", "births", "lives", "undecided", "sweeps", "sums", "levels", "escapes"}
    assert set(found) == set(PROMISES) - others
    rows = {name: check.rows for name, check in found.items()}
    assert rows["counts"] == SEQUENCES + 7  # and seven fills
    assert rows["values"] > CLASSES
    tables = ask(
        filled,
        "SELECT name FROM sqlite_schema WHERE type = 'table' AND name != 'alembic_version'"
        " AND name NOT LIKE 'sqlite_%'",
    )
    every = " UNION ALL ".join(f"SELECT count(*) n FROM {name}" for (name,) in tables)
    assert [(rows["file"],)] == ask(filled, f"SELECT sum(n) FROM ({every})")
    assert rows["classes"] == rows["statuses"] == CLASSES
    per_orbit = ("bounds", "walls", "reflection", "lengths", "lambda", "Hessian")
    orbits = Catalogue(filled).rows(Selection(statuses=(Status.ORBIT,)), columns=("representative",))
    assert {rows[name] for name in per_orbit} == {len(set(orbits))}
    assert rows["restarts"] == 2 * CLASSES
    assert there(found["bounds"].worst) < 1e-14  # areas that symmetry makes 0
    assert 0 < there(found["restarts"].worst) < 1e-13


FIRST_ORBIT = "(SELECT min(cycle) FROM orbit WHERE status = 'orbit' AND stadium = 1 AND cycle > 0)"
SOME_CLASS = "(SELECT id FROM cycle WHERE p = 6 ORDER BY id LIMIT 1 OFFSET 4)"


def test_pruned_words_have_no_class_to_check(small):
    chosen = Selection(contains="11", periods=((2, 5),), a=1.6)
    numbers = ask(
        small, "SELECT DISTINCT cycle FROM catalogue WHERE p <= 5 AND a = 1.6 AND code || code LIKE '%11%'"
    )
    found = checks(small, chosen)
    assert not any(check.failures for check in found.values())
    assert found["statuses"].rows == len(numbers)
    ((classes, words),) = ask(small, "SELECT count(*), sum(class_size) FROM cycle WHERE p <= 5")
    ((pruned,),) = ask(small, "SELECT count(*) FROM pruned WHERE p <= 5")
    assert (found["classes"].rows, found["counts"].rows) == (
        classes + pruned,
        words + 3,
    )  # one fill, and two of pruned words


def test_the_small_catalogue_is_sound_and_says_so(small, cli):
    outcome = cli("verify", "--json")
    assert outcome.code == 0
    rows = json.loads(outcome.out)
    assert [row["check"] for row in rows] == [name for name in PROMISES if name in {r["check"] for r in rows}]
    assert list(rows[0]) == ["check", "rows", "failures", "worst", "share", "first"]
    assert all(row["failures"] == 0 and row["first"] is None for row in rows)
    assert re.search(r": no errors in \d+ classes(, [1-9]\d* [a-z ]+)*, [\d.]+ s\n$", outcome.err)
    table = cli("verify")
    assert [line.split()[0] for line in table.out.splitlines()[1:]] == [
        row["check"].split()[0] for row in rows
    ]


def as_if_relaxed(path, chosen):
    """Make the rows at both a look as if the relaxation had found them."""
    nothing = "error = NULL, length_error = NULL, lyapunov_error = NULL, area_error = NULL"
    relaxed = "replace(parameters, 'newton', 'relaxation')"
    alter(
        path,
        f"INSERT INTO run SELECT 1000 + id, started, version, {relaxed}, commits FROM run",
        f"UPDATE orbit SET solver = 'relaxation', run = 1000 + run, {nothing} WHERE {chosen}",
    )


@pytest.mark.slow
def test_rows_of_the_relaxation_get_bounds_and_are_proved(small, cli):
    as_if_relaxed(small, f"cycle = {FIRST_ORBIT}")
    assert cli("verify", "--prove").code == 0


def test_rows_too_long_to_derive_bounds_are_skipped(small, monkeypatch):
    """The rows have no bounds, as from the relaxation; here, more than 5 bounces are too long."""
    monkeypatch.setattr("orbitdb.verification.check_orbits.MAX_DENSE", 5)
    ((before,),) = ask(small, "SELECT count(*) FROM orbit WHERE stadium = 1 AND error NOTNULL")
    of_six = "JOIN cycle ON id = cycle WHERE p = 6 AND status = 'orbit' AND stadium = 1"
    chosen = f"stadium = 1 AND cycle = (SELECT max(cycle) FROM orbit {of_six})"
    as_if_relaxed(small, chosen)
    found = checks(small)
    assert not [name for name, check in found.items() if check.failures]
    assert found["lengths"].rows == before - 1


def test_an_unreadable_value_fails_one_check_among_the_others(small, cli):
    alter(small, f"UPDATE cycle SET word = '013x' WHERE id = {SOME_CLASS}")
    outcome = cli("verify", "--json")
    assert outcome.code == 1
    rows = {row["check"]: row for row in json.loads(outcome.out)}
    assert rows["file"]["first"].startswith("classes, p = 6: ")
    assert rows["counts"]["failures"] == 0


def test_a_sample_still_checks_all_counts(filled):
    alter(filled, f"DELETE FROM cycle WHERE id = {SOME_CLASS}")
    assert "counts" in broken(filled, sample=1)


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--p", "12"], 1, "nothing to check"),
        (["--where", "lambda_c < 0"], 1, "nothing to check"),
        (["--where", "colour = 1"], 2, "colour"),
    ],
)
def test_nothing_to_verify_is_reported(filled, cli, arguments, code, message):
    outcome = cli("verify", *arguments)
    assert outcome.code == code
    assert message in outcome.err


def test_an_a_without_rows_has_nothing_to_check(small, cli):
    assert cli("births", "--p", "3").code == 0
    assert cli("verify", "--a", "2").says(1, "nothing to check", "a = 2", "orbitdb fill --p 11 --a 2")


@pytest.mark.slow
def test_births_alone_are_checked(born_once, cli):
    outcome = cli("verify", "--db", str(born_once), "--json")
    assert outcome.code == 0, outcome.err
    assert {check["check"]: check["failures"] for check in json.loads(outcome.out)}["births"] == 0


def test_everything_is_checked_if_no_stored_a_is_the_default(tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db")
    for a in (1.0, 2.0):
        catalogue.fill([3], a=a)
    found = Catalogue(catalogue.path).verify()
    assert found.sound
    assert {check.name: check.rows for check in found.checks}["counts"] == 8 + 2


def test_missing_periods_are_reported_at_every_a_that_lacks_some(small, cli):
    assert cli("simulate", "--a", "0.5", "--bounces", "1000").code == 0
    told = cli("verify", "--p", "5-7").err.splitlines()
    missing = [line.partition(" (")[0] for line in told if "not filled" in line]
    assert missing == [
        f"{which} not filled at a = {a}" for which, a in (("periods 5, 7 are", 1), ("period 7 is", 1.6))
    ]


@pytest.mark.slow
@pytest.mark.usefixtures("small_blocks")
def test_an_unfinished_period_is_not_a_failure(tmp_path):
    path = tmp_path / "half.db"
    migrate(path)
    going = fill_periods(path, 1.6, range(2, 9))
    step = next(step for step in going if step.p == 8 and step.words)
    going.close()
    assert step.words < step.total
    assert broken(path) == set()
    ((number,),) = ask(path, f"SELECT min(id) FROM cycle WHERE p = {step.p}")
    alter(path, f"DELETE FROM orbit WHERE cycle = {number}", f"DELETE FROM cycle WHERE id = {number}")
    assert broken(path) == {"counts"}


def test_joined_checks_keep_the_worst_of_all_rows():
    first = Check.measured("x", ["a", "b"], np.array([1.0, 2.0]), np.array([4.0, 4.0]))
    second = Check.measured("x", ["c", "d", "e"], np.array([3.0, np.nan, 0.0]), np.array([1.0, 1.0, 0.0]))
    assert first == Check("x", 2, 0, 2.0, 0.5, None)
    joined = first.joined(second)
    assert (joined.rows, joined.failures, joined.share, joined.first) == (5, 2, np.inf, "c")
    assert Check.measured("x", [], np.zeros(0), np.zeros(0)) == Check("x", 0)


def test_the_progress_of_every_stage_reaches_its_total(filled):
    with reading(filled) as connection:
        steps = list(verify(connection, [Selection()]))
    for stage in ("classes", "orbits"):
        of_stage = [step for step in steps if step.stage.startswith(stage)]
        assert [step.done for step in of_stage] == sorted(step.done for step in of_stage)
        assert 0 < of_stage[0].done <= of_stage[-1].done == of_stage[-1].total == CLASSES
    parts = [block.part("x", lambda *_: []) for block in blocks({4: np.arange(5), 3: np.arange(2)}, 3)]
    assert [(part.done, part.total) for part in parts] == [(3, 7), (5, 7), (7, 7)]


@pytest.mark.slow
def test_workers_find_the_same_failures(varied, tmp_path):
    path = tmp_path / "orbits.db"
    path.write_bytes(varied.read_bytes())
    alter(path, "UPDATE orbit SET length = length * 1.001 WHERE cycle = (SELECT min(cycle) FROM orbit)")
    alone = checks(path, restarts=2, seed=3)
    with Processes(2) as workers:
        assert checks(path, restarts=2, seed=3, workers=workers) == alone
    assert alone["lengths"].failures == 1


def test_rows_that_are_deleted_before_they_are_checked_are_not_passed_over(filled):
    with reading(filled) as connection:
        scope = Scope(connection, (Selection(1.6),))
        parts = [*classes(scope), *orbits(scope)]
    Catalogue(filled).delete(1.6, p=8)
    for part in parts:
        if part.stage.endswith("p = 8"):
            with pytest.raises(StoreError, match="classes of period 8 were deleted meanwhile"):
                checked_apart(filled, part, (Selection(1.6),))
        else:
            assert all(check.failures == 0 for check in checked_apart(filled, part, (Selection(1.6),)).checks)
