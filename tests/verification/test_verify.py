"""Verification: a sound catalogue passes, and whatever is altered by hand is found."""

import json
import re
import shutil
import sqlite3
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from quick import slow_but
from reference import refine
from solutions import representatives
from verified import checks

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.filling.periods import fill_geometric, fill_periods
from orbitdb.filling.single_word import fill_word
from orbitdb.filling.workers import Processes
from orbitdb.orbits.newton import solve
from orbitdb.orbits.orbit import EXISTING, NUMBERS, Orbits, Status
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.migrate import migrate
from orbitdb.symbols.words import from_strings, parse, to_strings
from orbitdb.verification.check import Check, measured
from orbitdb.verification.invariants import check_consistency
from orbitdb.verification.recomputation import restart
from orbitdb.verification.rigorous import certify
from orbitdb.verification.verify import PROMISES, report, verify

SEQUENCES, CLASSES = 3197, 498  # p = 2..8
STADIUMS = (1e-6, 1e-3, 0.2, 0.5, 1.0, 1.6, 2.5, 10.0, 1e4, 1e6)


def alter(path: Path, *statements: str) -> None:
    """Change a catalogue by hand."""
    plain = sqlite3.connect(path)
    with plain:
        for statement in statements:
            plain.execute(statement)
    plain.close()


def ask(path: Path, query: str) -> list[tuple]:
    plain = sqlite3.connect(path)
    rows = plain.execute(query).fetchall()
    plain.close()
    return rows


def broken(path: Path, **options) -> set[str]:
    return {name for name, check in checks(path, **options).items() if check.failures}


@pytest.fixture(scope="session")
def small_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("small") / "orbits.db"
    migrate(path)
    for a, periods in ((1.6, (5, 6)), (1.0, (6,))):
        for _ in fill_periods(path, a, periods):
            pass
    for _ in fill_geometric(path, range(2, 4)):
        pass
    fill_word(path, parse("1^30 5^29"), 1.6)
    return path


@pytest.fixture
def small(small_once: Path, tmp_path: Path) -> Path:
    """A catalogue with p = 5 and 6 at two a, pruned words and a long one, the test's own."""
    path = tmp_path / "orbits.db"
    path.write_bytes(small_once.read_bytes())
    return path


def test_a_sound_catalogue_passes_every_check(filled):
    found = checks(filled, restarts=2)
    assert {name for name, check in found.items() if check.failures} == set()
    others = {"certificates", "rules", "births", "changes", "lives", "undecided", "sweeps", "sums", "entropy"}
    others |= {"trajectories", "levels", "reading"}
    assert set(found) == set(PROMISES) - others
    rows = {name: check.rows for name, check in found.items()}
    assert rows["counts"] == SEQUENCES
    assert rows["classes"] == rows["values"] == rows["statuses"] == rows["bits"] == CLASSES
    per_orbit = ("bounds", "walls", "margins", "reflection", "lengths", "lambda", "signature", "Hessian")
    orbits = Catalogue(filled).rows(Selection(statuses=(Status.ORBIT,)), ("representative",))
    assert {rows[name] for name in per_orbit} == {len(set(orbits))}
    assert rows["restarts"] == 2 * CLASSES
    assert found["bounds"].worst == 0.0
    assert 0 < found["restarts"].worst < 1e-13


@pytest.mark.parametrize("a", slow_but([1e-6, 1.6], STADIUMS))
def test_no_sound_orbit_is_suspected_at_any_a(a):
    stadium = Stadium(a)
    for p in (2, 3, 6, 7):
        orbits = solve(representatives(p), stadium)
        for check in check_consistency(orbits.rows(np.isin(orbits.status, EXISTING)), stadium):
            assert not check.failures, check
        assert not restart(orbits.words, stadium, 2, np.random.default_rng(p)).failures


def test_of_many_rows_the_wrong_one_alone_is_named():
    """An orbit whose run goes back, one with a bounce beyond its wall, one with another margin."""
    orbits = solve(representatives(7), Stadium())
    orbits = orbits.rows(orbits.status == Status.ORBIT)
    codes, words, x = to_strings(orbits.words), orbits.words, orbits.coordinates.copy()
    back = next(i for i, code in enumerate(codes) if "11" in code)
    first = codes[back].index("11")
    x[back, [first, first + 1]] = x[back, [first + 1, first]]
    beyond = next(i for i, code in enumerate(codes) if "0" in code and i != back)
    x[beyond, codes[beyond].index("0")] = Stadium().a + 1e-9
    margin = np.where(np.arange(len(words)) == len(words) - 1, orbits.margin * (1 + 1e-9), orbits.margin)
    found = {
        check.name: check
        for check in check_consistency(replace(orbits, coordinates=x, margin=margin), Stadium())
    }
    assert (found["walls"].rows, found["walls"].failures) == (len(words), 2)
    assert found["walls"].first == codes[min(back, beyond)]
    assert found["reflection"].failures == 2
    assert found["margins"].failures in (2, 3)  # a run that goes back may have the margin that is stored


@pytest.mark.slow
@pytest.mark.parametrize("code", ["1^1000 5^1000", "1 2 (02)^300 3 2 (02)^300", "1^7 5^6"])
def test_long_orbits_are_not_suspected(code):
    orbits = solve(from_strings([parse(code)]), Stadium())
    assert orbits.status.tolist() == ["orbit"]
    found = {check.name: check for check in check_consistency(orbits, Stadium())}
    assert found["reflection"].rows == found["lambda"].rows == 1
    assert not any(check.failures for check in found.values())


FIRST_ORBIT = "(SELECT min(cycle) FROM orbit WHERE status = 'orbit' AND stadium = 1 AND cycle > 0)"
SOME_CLASS = "(SELECT id FROM cycle WHERE p = 6 ORDER BY id LIMIT 1 OFFSET 4)"


def test_pruned_words_among_the_chosen_have_no_class_to_check(small):
    chosen = Selection(contains="11", periods=((2, 5),), a=1.6)
    numbers = ask(
        small, "SELECT DISTINCT cycle FROM catalogue WHERE p <= 5 AND a = 1.6 AND code || code LIKE '%11%'"
    )
    found = checks(small, chosen)
    assert not any(check.failures for check in found.values())
    assert found["statuses"].rows == len(numbers)


def test_the_small_catalogue_is_sound_and_says_so(small, cli):
    outcome = cli("verify", "--json")
    assert outcome.code == 0
    rows = json.loads(outcome.out)
    assert [row["check"] for row in rows] == [name for name in PROMISES if name in {r["check"] for r in rows}]
    assert list(rows[0]) == ["check", "rows", "failures", "worst", "share", "first"]
    assert all(row["failures"] == 0 and row["first"] is None for row in rows)
    assert re.search(r": all is well with \d+ classes(, [1-9]\d* [a-z ]+)*, [\d.]+ s\n$", outcome.err)
    table = cli("verify")
    assert [line.split()[0] for line in table.out.splitlines()[1:]] == [
        row["check"].split()[0] for row in rows
    ]


def flipped(blob: bytes, coordinate: int, bit: int) -> bytes:
    places = list(struct.unpack(f"<{len(blob) // 8}q", blob))
    places[coordinate] ^= -(2**63) if bit == 63 else 1 << bit
    return struct.pack(f"<{len(places)}q", *places)


def flip_every_bit(path: Path) -> dict[str, float]:
    """Flip another bit in the first coordinate of each of 64 orbits; return by word the change made.

    Coordinates of 0 are left, for flips of their sign or lowest bits make no other orbit.
    """
    rows = ask(
        path,
        "SELECT stadium, cycle, word, coordinates, error FROM orbit JOIN cycle ON cycle.id = orbit.cycle"
        " WHERE p = 8 AND status = 'orbit' ORDER BY cycle",
    )
    moved = [row for row in rows if abs(struct.unpack("<d", row[3][:8])[0]) > 0.01][:64]
    assert len(moved) == 64
    plain = sqlite3.connect(path)
    changes = {}
    with plain:
        for bit, (stadium, cycle, word, blob, error) in enumerate(moved):
            new = flipped(blob, 0, bit)
            key = (new, stadium, cycle)
            plain.execute("UPDATE orbit SET coordinates = ? WHERE stadium = ? AND cycle = ?", key)
            before, after = (struct.unpack("<d", data[:8])[0] for data in (blob, new))
            changes[word] = abs(after - before) / error if np.isfinite(after) else np.inf
    plain.close()
    return changes


@pytest.mark.slow
def test_every_single_bit_of_a_coordinate_is_found(filled):
    flip_every_bit(filled)
    found = checks(filled)
    assert found["values"].failures + found["bits"].failures == 64


@pytest.mark.slow
def test_elsewhere_every_bit_beyond_the_bound_is_found(filled):
    """Where other libraries compute, last bits may differ, and only what the bounds allow is let pass."""
    changes = flip_every_bit(filled)
    alter(filled, """UPDATE run SET parameters = json_set(parameters, '$.arithmetic', 'an abacus')""")
    found = checks(filled)
    assert found["bits"].rows == 0
    beyond = sum(share > 2 for share in changes.values())
    within = sum(share <= 1 for share in changes.values())
    assert beyond > 40
    assert within > 2
    assert beyond <= found["values"].failures + found["bounds"].failures <= 64 - within


@pytest.mark.slow
def test_elsewhere_is_told_and_not_a_failure(small, cli):
    alter(small, "UPDATE run SET version = '0.0.1'")
    outcome = cli("verify")
    assert outcome.code == 0
    assert "last bits were not compared" in outcome.err
    alter(small, "UPDATE run SET parameters = 'not json'")
    assert broken(small) == {"provenance"}


@pytest.mark.parametrize("a", slow_but([1.6], [0.2, 1.0, 1.6, 10.0]))
@pytest.mark.parametrize("p", [8, 40, 100])
def test_a_solution_has_the_same_bits_in_any_batch(a, p):
    rng = np.random.default_rng(p)
    if p == 8:
        words = representatives(8)
    else:
        runs = rng.integers(1, 4, size=(60, p))
        texts = ["".join("1" * k if i % 2 == 0 else "3" * k for i, k in enumerate(row)) for row in runs]
        words = from_strings(sorted({text[: p - 1] + "3" for text in texts if text[p - 2] in "13"}))
    orbits = solve(words, Stadium(a))
    for size in (1, 2, 5, 30):
        rows = rng.permutation(len(words))[:size]
        again = solve(words[rows], Stadium(a))
        for name in ("coordinates", "iterations", *NUMBERS):
            assert getattr(again, name).tobytes() == getattr(orbits.rows(rows), name).tobytes()


def as_if_relaxed(path, chosen):
    """Make rows look as if a run had found them by relaxation, at both a."""
    nothing = "error = NULL, length_error = NULL, lyapunov_error = NULL"
    relaxed = "replace(parameters, 'newton', 'relaxation')"
    alter(
        path,
        f"INSERT INTO run SELECT 1000 + id, started, version, {relaxed} FROM run",
        f"UPDATE orbit SET solver = 'relaxation', run = 1000 + run, {nothing} WHERE {chosen}",
    )


@pytest.mark.slow
def test_rows_without_bounds_are_the_relaxation_s_alone(small, cli):
    as_if_relaxed(small, f"cycle = {FIRST_ORBIT}")
    outcome = cli("verify", "--rigorous")
    assert outcome.code == 0
    assert "rows come from another method" in outcome.err
    alter(small, f"UPDATE orbit SET solver = 'newton' WHERE cycle = {FIRST_ORBIT}")
    assert "values" in broken(small)


def test_rows_too_long_for_bounds_of_their_own_are_left(small, monkeypatch):
    """As the relaxation leaves them; here those of more than 5 bounces."""
    monkeypatch.setattr("orbitdb.verification.invariants.MAX_DENSE", 5)
    ((before,),) = ask(small, "SELECT count(*) FROM orbit WHERE stadium = 1 AND error NOTNULL")
    of_six = "JOIN cycle ON id = cycle WHERE p = 6 AND status = 'orbit' AND stadium = 1"
    chosen = f"stadium = 1 AND cycle = (SELECT max(cycle) FROM orbit {of_six})"
    as_if_relaxed(small, chosen)
    found = checks(small)
    assert not [name for name, check in found.items() if check.failures]
    assert found["lengths"].rows == before - 1


def moved(orbits: Orbits, name: str, by: float) -> Orbits:
    """Move one number of the first row by so many times its error bound."""
    bound = {"coordinates": "error", "length": "length_error", "lyapunov": "lyapunov_error"}[name]
    values = getattr(orbits, name).copy()
    values[0] += by * getattr(orbits, bound)[0]
    return replace(orbits, **{name: values})


@pytest.mark.parametrize(
    ("name", "suspected"),
    [
        ("coordinates", {"reflection", "margins"}),
        ("length", {"lengths"}),
        ("lyapunov", {"lambda", "Hessian"}),
    ],
)
@pytest.mark.parametrize("a", [0.5, 1.6])
def test_consistency_alone_finds_a_moved_number(a, name, suspected):
    """A thousand bounds are enough: the checks by plane geometry are that sharp."""
    stadium = Stadium(a)
    orbits = solve(representatives(7), stadium)
    orbits = orbits.rows(orbits.status == "orbit")
    for by, expected in ((1e3, suspected), (0.1, set())):
        found = {c.name: c for c in check_consistency(moved(orbits, name, by), stadium)}
        failing = {check for check in found if found[check].failures}
        assert bool(failing & suspected) == bool(expected)
        assert all(found[check].first == to_strings(orbits.words[:1])[0] for check in failing)


@pytest.mark.parametrize("step", slow_but([3], [1, 3]))
def test_certificates_hold_what_they_promise(small, cli, step):
    """The radius lies between the true error, by 50 digits from plane geometry, and the stored bound."""
    outcome = cli("verify", "--rigorous", "--a", "1.6", "--json")
    assert outcome.code == 0
    (certificates,) = (row for row in json.loads(outcome.out) if row["check"] == "certificates")
    rows = ask(
        small,
        "SELECT word, coordinates, radius, error, bits, status FROM certificate JOIN orbit USING"
        " (stadium, cycle) JOIN cycle ON cycle.id = orbit.cycle WHERE stadium = 1",
    )
    assert certificates["rows"] == len(rows)
    assert ask(small, "SELECT count(*) FROM orbit WHERE stadium = 1") == [(len(rows),)]
    orbits = [row for row in rows if row[5] == "orbit" and len(row[0]) <= 5]
    assert len(orbits) > 5
    for word, blob, radius, error, bits, _ in orbits[::step]:
        places = np.frombuffer(blob, dtype="<f8").tolist()
        truth = refine(word, 1.6, places).coordinates
        true = max(float(abs(x - y)) for x, y in zip(truth, places, strict=True))
        assert true <= radius * (1 + 1e-12)
        assert radius <= error
        assert radius <= true * (1 + 1e-6) + 1e-30
        assert bits >= 128
    assert cli("verify").code == 0


def test_orbits_through_a_joint_are_certified(small, cli):
    assert cli("verify", "--rigorous", "--a", "1").code == 0
    query = "SELECT count(*) FROM orbit JOIN certificate USING (stadium, cycle) WHERE status = 'boundary'"
    assert ask(small, query)[0][0] > 0


@pytest.mark.slow
def test_certification_goes_on_where_it_was_stopped(filled):
    steps = certify(filled, Selection())
    first = next(steps)
    steps.close()
    kept = ask(filled, "SELECT cycle, radius, run FROM certificate ORDER BY cycle")
    assert len(kept) == first.done == first.checks[0].rows
    assert 0 < len(kept) < CLASSES
    (rest,) = report(certify(filled, Selection()))
    assert rest.rows == CLASSES - len(kept)
    assert report(certify(filled, Selection())) == []
    (again,) = report(certify(filled, Selection(), again=True))
    assert again.rows == CLASSES
    found = ask(filled, "SELECT cycle, radius FROM certificate ORDER BY cycle")
    assert [row for row in found if row[0] in dict.fromkeys(k[0] for k in kept)] == [k[:2] for k in kept]
    assert ask(filled, "SELECT count(DISTINCT run) FROM certificate") == [(1,)]


def test_an_altered_row_gets_no_certificate_and_loses_the_one_it_had(small, cli):
    assert cli("verify", "--rigorous", "--p", "5", "--a", "1.6").code == 0
    ((cycle, word),) = ask(small, "SELECT id, word FROM cycle WHERE p = 5 ORDER BY id LIMIT 1")
    assert ask(small, f"SELECT count(*) FROM certificate WHERE cycle = {cycle}") == [(1,)]
    alter(small, f"UPDATE orbit SET lyapunov = lyapunov + 3 * lyapunov_error WHERE cycle = {cycle}")
    outcome = cli("verify", "--rigorous", "--again", "--p", "5", "--a", "1.6", "--json")
    assert outcome.code == 1
    failing = {row["check"]: row for row in json.loads(outcome.out) if row["failures"]}
    assert failing["certificates"]["failures"] == 1
    assert failing["certificates"]["first"] == f"{word} at a = 1.6"
    assert ask(small, f"SELECT count(*) FROM certificate WHERE cycle = {cycle}") == [(0,)]


def test_what_cannot_be_compared_is_left(small):
    """Counts of a fill that goes on, and bits of another version."""
    alter(
        small,
        "UPDATE fill SET state = 'filling', n_c = NULL, classes = 0 WHERE p = 6 AND stadium = 2",
        "UPDATE orbit SET iterations = 9, run = (SELECT min(id) FROM run)",
        "UPDATE run SET version = '0.0.1' WHERE id = (SELECT min(id) FROM run)",
    )
    found = checks(small, Selection(a=1.0, statuses=(Status.ORBIT,)))
    assert [name for name, check in found.items() if check.failures] == ["provenance"]  # a run at another a
    assert (found["fills"].rows, found["bits"].rows) == (1, 0)


def test_a_value_that_no_command_can_read_fails_a_check_among_the_others(tmp_path, cli):
    """The births that count the orbits of a fill stop at the word; the table has all the other checks."""
    path = tmp_path / "orbits.db"
    for command in (["fill", "--p", "5"], ["births", "--p", "5"]):
        assert cli(*command, "--db", str(path)).code == 0
    alter(path, f"UPDATE cycle SET word = '013x' WHERE id = {0o101023}")
    outcome = cli("verify", "--db", str(path), "--json")
    assert outcome.code == 1
    failing = {row["check"]: row["first"] for row in json.loads(outcome.out) if row["failures"]}
    assert failing["classes"] == "013x"
    assert failing["reading"] == "births: a class of period '5'"


def test_a_sample_still_checks_all_counts(filled):
    alter(filled, f"DELETE FROM cycle WHERE id = {SOME_CLASS}")
    assert "counts" in broken(filled, sample=1)


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--a", "2"], 1, "nothing to check"),
        (["--p", "12"], 1, "nothing to check"),
        (["--where", "lambda_c < 0"], 1, "nothing to check"),
        (["--again"], 2, "--rigorous"),
        (["--sample", "0"], 2, "--sample"),
        (["--a", "-1"], 2, "half length"),
        (["--where", "colour = 1"], 2, "colour"),
        (["--db", "nowhere.db"], 3, "orbitdb fill"),
    ],
)
def test_what_cannot_be_verified_says_so(filled, cli, arguments, code, message):
    outcome = cli("verify", *arguments)
    assert outcome.code == code
    assert message in outcome.err


@pytest.mark.slow
@pytest.mark.usefixtures("small_blocks")
def test_a_period_in_the_making_is_no_failure(tmp_path):
    path = tmp_path / "half.db"
    migrate(path)
    going = fill_periods(path, 1.6, range(2, 9))
    step = next(step for step in going if step.p == 8 and step.words)
    going.close()
    assert step.words < step.total
    assert broken(path) == set()
    for which in ("min", "max"):  # that last one is where it goes on
        lacking = tmp_path / f"{which}.db"
        shutil.copy(path, lacking)
        ((number,),) = ask(path, f"SELECT {which}(id) FROM cycle WHERE p = {step.p}")
        alter(lacking, f"DELETE FROM orbit WHERE cycle = {number}", f"DELETE FROM cycle WHERE id = {number}")
        assert broken(lacking) == {"fills"}


def test_checks_join_to_the_worst_of_all_rows():
    first = measured("x", ["a", "b"], np.array([1.0, 2.0]), np.array([4.0, 4.0]))
    second = measured("x", ["c", "d", "e"], np.array([3.0, np.nan, 0.0]), np.array([1.0, 1.0, 0.0]))
    assert first == Check("x", 2, 0, 2.0, 0.5, None)
    joined = first.joined(second)
    assert (joined.rows, joined.failures, joined.share, joined.first) == (5, 2, np.inf, "c")
    assert measured("x", [], np.zeros(0), np.zeros(0)) == Check("x", 0)


def test_every_stage_comes_to_its_end(filled):
    steps = list(verify(Catalogue(filled), [Selection()]))
    for stage in ("classes", "orbits"):
        of_stage = [step for step in steps if step.stage.startswith(stage)]
        assert [step.done for step in of_stage] == sorted(step.done for step in of_stage)
        assert 0 < of_stage[0].done <= of_stage[-1].done == of_stage[-1].total == CLASSES


@pytest.mark.slow
def test_what_workers_find_is_the_same(varied, tmp_path):
    path = tmp_path / "orbits.db"
    path.write_bytes(varied.read_bytes())
    alter(path, "UPDATE orbit SET length = length * 1.001 WHERE cycle = (SELECT min(cycle) FROM orbit)")
    alone = checks(path, restarts=2, seed=3)
    with Processes(2) as workers:
        assert checks(path, restarts=2, seed=3, workers=workers) == alone
    assert alone["lengths"].failures == 1
