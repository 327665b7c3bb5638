"""`verify` finds every value altered by hand in a sound file, in each table that a command shows."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from contents import ask, checks
from processes import run_here

from orbitdb.orbits.births import find_changes
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import reading
from orbitdb.store.writing.classes import add_changes, add_class
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.symmetry import class_of
from orbitdb.symbols.words import from_strings
from orbitdb.verification.provenance import check_provenance

pytestmark = pytest.mark.slow

BORN_LATE = "(SELECT cycle FROM change WHERE a > 0 ORDER BY cycle LIMIT 1)"
ONLY_BORN = "(SELECT max(id) FROM cycle WHERE p = 7)"

LONG = "(SELECT max(id) FROM cycle)"
ORBIT = "(SELECT min(cycle) FROM orbit WHERE status = 'orbit' AND stadium = 1 AND cycle > 0)"
PRUNED = "(SELECT min(cycle) FROM orbit WHERE status = 'dynamical' AND stadium = 1)"
CLASS = "(SELECT id FROM cycle WHERE p = 5 ORDER BY id LIMIT 1 OFFSET 4)"
EIGHT = "(SELECT max(id) FROM cycle WHERE p = 7 AND class_size = 8)"


def renumbered(old: str, new: str) -> str:
    """Return SQL statements that give a class another id wherever the id occurs."""
    tables = ("orbit", "change", "certificate")
    others = "".join(f"; UPDATE {name} SET cycle = {new} WHERE cycle = {old}" for name in tables)
    return f"UPDATE cycle SET id = {new} WHERE id = {old}{others}"


ALTERATIONS = {
    "change.a": (f"UPDATE change SET a = a * 1.001 WHERE cycle = {BORN_LATE}", "changes"),
    "change.a always": ("UPDATE change SET a = 0.3, error = 1e-15, bounce = 1, joint = 'top left', slope = 1"
                        " WHERE a = 0 AND cycle = (SELECT max(cycle) FROM change WHERE a = 0)", "changes"),
    "change.error": (f"UPDATE change SET error = 1e-30 WHERE cycle = {BORN_LATE}", "changes"),
    "change.kind": (f"UPDATE change SET kind = 'died' WHERE cycle = {BORN_LATE}", "births"),
    "change.bounce": (f"UPDATE change SET bounce = bounce + 1 WHERE cycle = {BORN_LATE}", "changes"),
    "change.joint": (
        "UPDATE change SET joint = CASE joint WHEN 'top left' THEN 'bottom right' ELSE 'top left' END"
        f" WHERE cycle = {BORN_LATE}", "changes"),
    "change.slope": (f"UPDATE change SET slope = slope * 1.001 WHERE cycle = {BORN_LATE}", "changes"),
    "change.event": (f"UPDATE change SET event = event + 1 WHERE cycle = {BORN_LATE}", "births"),
    "birth_fill deleted": ("DELETE FROM birth_fill WHERE p = 7", "births"),
    "birth_fill.largest": ("UPDATE birth_fill SET largest = largest + 1 WHERE p = 7", "births"),
    "cycle.symmetry": (f"UPDATE cycle SET symmetry = 'x,T,xT' WHERE id = {ONLY_BORN}", "classes"),
    "cycle.time_reversal": (
        "UPDATE cycle SET time_reversal = CASE time_reversal WHEN 'self' THEN 'pair' ELSE 'self' END"
        f" WHERE id = {ONLY_BORN}", "classes"),
    "cycle.walls": (f"UPDATE cycle SET walls = walls + 1 WHERE id = {ONLY_BORN}", "classes"),
    "cycle.class_size": (f"UPDATE cycle SET class_size = 4 WHERE id = {EIGHT}", "classes"),
    "cycle.words, one less": (
        f"UPDATE cycle SET words = substr(words, 1, 7 * p) WHERE id = {EIGHT}", "classes"),
    "cycle.words, one more": (f"UPDATE cycle SET words = words || word WHERE id = {EIGHT}", "classes"),
    "cycle.words, in another order": (
        "UPDATE cycle SET words = word || substr(words, 1 + 2 * p, p) || substr(words, 1 + p, p)"
        f" || substr(words, 1 + 3 * p) WHERE id = {EIGHT}", "classes"),
    "cycle.words, one turned": (
        "UPDATE cycle SET words = word || substr(words, 2 + p, p - 1) || substr(words, 1 + p, 1)"
        f" || substr(words, 1 + 2 * p) WHERE id = {EIGHT}", "classes"),
    "cycle.words, those of another": (
        f"UPDATE cycle SET words = (SELECT words FROM cycle WHERE id < {EIGHT} AND class_size = 8 AND p = 7)"
        f" WHERE id = {EIGHT}", "classes"),
    "cycle.words, no digits": (
        f"UPDATE cycle SET words = replace(words, '1', 'x') WHERE id = {EIGHT}", "classes"),
    "cycle.words, long": (f"UPDATE cycle SET words = word || word WHERE id = {LONG}", "classes"),
    "cycle.word turned": (
        "UPDATE cycle SET word = substr(word, 2) || substr(word, 1, 1),"
        f" words = substr(word, 2) || substr(word, 1, 1) || substr(words, 1 + p)"
        f" WHERE id = {EIGHT}", "classes"),
    "cycle.word, another of the class": (
        f"UPDATE cycle SET word = substr(words, 1 + p, p) WHERE id = {EIGHT}", "classes"),
    "cycle.word, long": (f"UPDATE cycle SET word = substr(words, 1 + p, p) WHERE id = {LONG}", "classes"),
    "cycle.word, no word": (f"UPDATE cycle SET word = '013x' WHERE id = {CLASS}", "classes"),
    "cycle.p": (f"UPDATE cycle SET p = 6 WHERE id = {EIGHT}", "classes"),
    "cycle.p, long": (f"UPDATE cycle SET p = 60 WHERE id = {LONG}", "classes"),
    "cycle.id": (f"UPDATE cycle SET id = id + 1 WHERE id = {EIGHT}", "foreign keys"),
    "cycle.id of an orbit": (renumbered(str(0o101023), str(0o101024)), "classes"),
    "cycle.id of another period": (renumbered(str(0o101023), str(0o1777777777)), "classes"),
    "cycle.id below 0": (renumbered(str(0o101023), str(-0o101023)), "classes"),
    "cycle.id without a period": (renumbered(str(0o101023), "5"), "classes"),
    "cycle.id beyond all": (renumbered(str(0o101023), str(2**63 - 1)), "classes"),
    "cycle.id, short among long": (renumbered(str(0o101023), str((7 << 58) + 9)), "classes"),
    "cycle.id, long among short": (renumbered(str(7 << 58), str(0o101024)), "classes"),
    "cycle twice": (
        "INSERT INTO cycle SELECT id + 1, p, substr(words, 1 + p, p), class_size, walls, time_reversal,"
        f" symmetry, words FROM cycle WHERE id = {EIGHT}", "classes"),
    "cycle deleted": (
        f"DELETE FROM orbit WHERE cycle = {0o101023}; DELETE FROM certificate WHERE cycle > {0o101023};"
        f"DELETE FROM cycle WHERE id = {0o101023}", "counts"),
    "element.element": (
        "UPDATE element SET element = 7 - element WHERE symmetry = '1' AND n = 5", "elements"),
    "element.n": ("UPDATE element SET n = 5 WHERE symmetry = 'x' AND n = 3", "elements"),
    "element deleted": ("DELETE FROM element WHERE symmetry = 'T' AND n = 0", "elements"),
    "element inserted": ("INSERT INTO element VALUES ('z', 0, 0)", "elements"),
    "pruned.rules": ("UPDATE pruned SET rules = '2' WHERE word = '001'", "rules"),
    "pruned.rules, long": ("UPDATE pruned SET rules = rules || ',6' WHERE p > 20", "rules"),
    "pruned.word": ("UPDATE pruned SET word = '010' WHERE word = '001'", "rules"),
    "pruned.word, no word": ("UPDATE pruned SET word = '0 1' WHERE word = '001'", "rules"),
    "pruned.p": ("UPDATE pruned SET p = 4 WHERE word = '001'", "rules"),
    "pruned.id": ("UPDATE pruned SET id = id - 1 WHERE word = '455'", "rules"),
    "pruned.id above 0": ("UPDATE pruned SET id = -id WHERE word = '001'", "rules"),
    "pruned.id, long": ("UPDATE pruned SET id = -7 WHERE p > 20", "rules"),
    "pruned, an admissible word": (f"INSERT INTO pruned VALUES ({-0o10013}, 4, '0013', '')", "rules"),
    "pruned, the family": (f"INSERT INTO pruned VALUES ({-0o102}, 2, '02', '3')", "rules"),
    "pruned, a repetition": (f"INSERT INTO pruned VALUES ({-0o1000000}, 6, '000000', '1,3')", "rules"),
    "trajectory.lambda_d": ("UPDATE trajectory SET lambda_d = 0.5", "trajectories"),
    "trajectory, both lambdas": (
        "UPDATE trajectory SET lambda_c = lambda_c * 0.5 / lambda_d, lambda_d = 0.5", "trajectories"),
    "trajectory, both errors": (
        "UPDATE trajectory SET lambda_d_error = lambda_d_error / 1e6, lambda_c_error = lambda_c_error / 1e6",
        "trajectories"),
    "trajectory.groups": ("UPDATE trajectory SET groups = 1", "trajectories"),
    "trajectory.mean_free_path_error": ("UPDATE trajectory SET mean_free_path_error = 9e999", "trajectories"),
    "trajectory.mean_free_path": ("UPDATE trajectory SET mean_free_path = 3", "trajectories"),
    "trajectory.seed": ("UPDATE trajectory SET seed = '7'", "trajectories"),
    "trajectory.stadium": (
        "UPDATE trajectory SET stadium = (SELECT id FROM stadium WHERE a = 0.5)", "trajectories"),
    "entropy_bound.a": ("UPDATE entropy_bound SET a = 1.0 WHERE proof = 'balls'", "entropy"),
    "entropy_bound.windows": ("UPDATE entropy_bound SET windows = windows + 1 WHERE edges = 6", "entropy"),
    "entropy_bound.upper": ("UPDATE entropy_bound SET upper = upper - 1e-7 WHERE proof = 'balls'", "entropy"),
    "entropy_bound of another version, below all others": (
        "UPDATE run SET version = '0.1'; UPDATE entropy_bound SET lower = 0, upper = 0.5 WHERE edges = 6",
        "entropy"),
    "entropy_bound of another version, above all others": (
        "UPDATE run SET version = '0.1'; UPDATE entropy_bound SET lower = 1.2, upper = 1.21 WHERE edges = 6",
        "entropy"),
    "level.k": ("UPDATE level SET k = k + 1e-8 WHERE number = 1", "levels"),
    "level.error": ("UPDATE level SET error = 1e-15", "levels"),
    "level deleted": ("DELETE FROM level WHERE number = (SELECT max(number) FROM level)", "levels"),
    "level.a": ("UPDATE level SET a = 1.5; UPDATE level_fill SET a = 1.5", "levels"),
    "level_fill.below": (
        "UPDATE level SET number = number + 100; UPDATE level_fill SET below = 100", "levels"),
    "level_fill.high": ("UPDATE level_fill SET high = 4.5", "levels"),
    "level_fill.low": ("UPDATE level_fill SET low = 3.999", "levels"),
    "level_fill.run": ("UPDATE run SET parameters = '{}'", "provenance"),
    "orbit.solver": ("UPDATE orbit SET solver = 'relaxation'", "provenance"),
    "orbit.iterations": ("UPDATE orbit SET iterations = iterations + 1 WHERE status = 'orbit'", "bits"),
    "orbit.length": ("UPDATE orbit SET length = length * (1 + 1e-12) WHERE status = 'orbit'", "bounds"),
    "certificate.bits": ("UPDATE certificate SET bits = 100", "provenance"),
    "certificate.version": ("UPDATE certificate SET version = '9.9'", "provenance"),
    "certificate.radius": ("UPDATE certificate SET radius = -radius", "provenance"),
    "run.parameters": ("UPDATE run SET parameters = '{}'", "provenance"),
    "sweep.n_c": ("UPDATE sweep SET n_c = n_c - 1 WHERE p = 7", "sweeps"),
    "sweep.state": ("UPDATE sweep SET state = 'filling' WHERE p = 7", "sweeps"),
    "sweep.cursor": ("UPDATE sweep SET cursor = '0313131' WHERE p = 7", "sweeps"),
    "fill.words of a whole period": ("UPDATE fill SET words = words + 1 WHERE p = 5", "fills"),
    "fill.state": ("UPDATE fill SET state = 'filling' WHERE p = 5", "fills"),
    "fill.cursor of a whole period": ("UPDATE fill SET cursor = '03132' WHERE p = 5", "fills"),
    "fill deleted": ("DELETE FROM fill WHERE p = 5", "fills"),
    "all fills deleted": ("DELETE FROM fill", "fills"),
    "birth_fill.cursor of a whole period": (
        "UPDATE birth_fill SET cursor = '0313131' WHERE p = 7", "births"),
    "birth_fill.state": ("UPDATE birth_fill SET state = 'filling' WHERE p = 7", "births"),
    "entropy_bound.proof": (
        "UPDATE entropy_bound SET proof = 'balls' WHERE edges = 6 AND proof = 'doubles'", "provenance"),
    "fill.n_c": ("UPDATE fill SET n_c = n_c - 1 WHERE p = 5", "fills"),
    "fill.words": ("UPDATE fill SET state = 'filling', words = words - 1 WHERE p = 5", "fills"),
    "fill.cursor": ("UPDATE fill SET state = 'filling', cursor = '0x' WHERE p = 5", "fills"),
    "fill.cursor, too far": (
        f"UPDATE fill SET state = 'filling' WHERE p = 5;"
        f"DELETE FROM orbit WHERE cycle = {0o101023}", "fills"),
    "fill.p": ("UPDATE fill SET p = 99 WHERE p = 5", "fills"),
    "birth_fill.p": ("UPDATE birth_fill SET p = 99 WHERE p = 7", "reading"),
    "birth_fill.words": ("UPDATE birth_fill SET state = 'filling', words = words + 1 WHERE p = 7", "births"),
    "birth_fill.cursor": (
        f"UPDATE birth_fill SET state = 'filling' WHERE p = 7;"
        f"DELETE FROM change WHERE cycle = {EIGHT}", "births"),
    "status of an orbit": (f"UPDATE orbit SET status = 'boundary' WHERE cycle = {ORBIT}", "statuses"),
    "an orbit called pruned": (f"UPDATE orbit SET status = 'dynamical' WHERE cycle = {ORBIT}", "values"),
    "an orbit called pruned, its numbers removed": (
        "UPDATE orbit SET status = 'dynamical', coordinates = NULL, length = NULL, lyapunov = NULL,"
        " residual = NULL, error = NULL, length_error = NULL, lyapunov_error = NULL"
        f" WHERE cycle = {ORBIT}", "statuses"),
    "a pruned word called undecided": (
        f"UPDATE orbit SET status = 'unresolved' WHERE cycle = {PRUNED}", "unresolved"),
    "a status nobody knows": (f"UPDATE orbit SET status = 'odd' WHERE cycle = {ORBIT}", "values"),
    "side of a margin": (f"UPDATE orbit SET margin = -margin WHERE cycle = {PRUNED}", "statuses"),
    "margin": (f"UPDATE orbit SET margin = margin + 1e-9 WHERE cycle = {ORBIT}", "margins"),
    "residual": (f"UPDATE orbit SET residual = residual + 1e-9 WHERE cycle = {ORBIT}", "residuals"),
    "lambda": (f"UPDATE orbit SET lyapunov = lyapunov + 1e-10 WHERE cycle = {ORBIT}", "Hessian"),
    "lambda beyond its bound": (
        f"UPDATE orbit SET lyapunov = lyapunov + 4 * lyapunov_error WHERE cycle = {ORBIT}", "bounds"),
    "an error bound": (f"UPDATE orbit SET error = error / 2 WHERE cycle = {ORBIT}", "bits"),
    "a negative error bound": (f"UPDATE orbit SET length_error = -1 WHERE cycle = {ORBIT}", "values"),
    "solver": (f"UPDATE orbit SET solver = 'magic' WHERE cycle = {ORBIT}", "values"),
    "a coordinate lost": (
        f"UPDATE orbit SET coordinates = substr(coordinates, 9) WHERE cycle = {ORBIT}", "values"),
    "a missing class": (f"DELETE FROM cycle WHERE id = {CLASS}", "foreign keys"),
    "a missing row": (f"DELETE FROM orbit WHERE cycle = {ORBIT}", "fills"),
    "N_t": ("UPDATE fill SET n_t = n_t + 1 WHERE p = 5", "fills"),
    "Moreau's number": ("UPDATE fill SET primitive = primitive + 1 WHERE p = 5", "fills"),
    "a rule's number": ("UPDATE fill SET rule_4 = rule_4 + 1 WHERE p = 5", "fills"),
    "state": ("UPDATE fill SET state = 'finished' WHERE p = 5", "fills"),
    "a run that is not there": (f"UPDATE orbit SET run = 99 WHERE cycle = {ORBIT}", "foreign keys"),
    "a dangling certificate": ("INSERT INTO certificate VALUES (1, 9999, 0, 128, '0', 1)", "foreign keys"),
    "a certificate beyond the bound": (
        f"UPDATE certificate SET radius = 1e-3 WHERE cycle = {ORBIT}", "radii"),
    "a certificate of a pruned word": (
        f"INSERT INTO certificate SELECT 1, {PRUNED}, 1e-9, 128, version, run FROM certificate LIMIT 1",
        "radii"),
    "no a": ("UPDATE stadium SET a = -1 WHERE a = 0.5", "provenance"),
    "another a": ("UPDATE stadium SET a = 0.5000000000000001 WHERE a = 0.5", "provenance"),
    "alembic_version deleted": ("DELETE FROM alembic_version", "schema"),
    "alembic_version changed": ("UPDATE alembic_version SET version_num = '0001'", "schema"),
}  # fmt: skip
"""By name, the statements that alter the file, and the check that must fail."""

COMMANDS = [
    ["fill", "--p", "5"],
    ["fill", "--p", "4", "--a", "0.5"],
    ["fill", "--p", "2-3", "--geometric"],
    ["fill", "--code", "1^30 5^29"],
    ["fill", "--code", "0^30 1"],
    ["births", "--p", "7"],
    ["sweep", "--p", "7"],
    ["simulate", "--bounces", "100000"],
    ["bounds", "--a", "1.6", "--window", "6", "--store"],
    ["bounds", "--a", "1.6", "--window", "5", "--store", "--prove"],
    ["verify", "--rigorous", "--p", "2-4", "--a", "1.6"],
]


OF_LEVELS = [["levels", "--k", "0:4", "--parity", "oo"]]
"""In a separate file, because checking levels takes a second."""


def made(path: Path, commands: list[list[str]]) -> Path:
    for command, code, err in run_here(commands, path):
        assert code == 0, (command, err)
    return path


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> Path:
    path, word = made(tmp_path_factory.mktemp("sound") / "orbits.db", COMMANDS), "010203113"
    with closing(Writer(path, {"command": "births"})) as writer, writer.writing() as connection:
        number = add_class(connection, class_of(word))
        add_changes(writer, connection, [number], find_changes(from_strings([word])))  # one is a death
        begun = "INSERT INTO birth_fill (p, state, words, seconds) VALUES (9, 'filling', 0, 0)"
        connection.exec_driver_sql(begun)
    return path


@pytest.fixture(scope="module")
def sound_levels(tmp_path_factory) -> Path:
    return made(tmp_path_factory.mktemp("sound") / "levels.db", OF_LEVELS)


def found_wrong(path: Path) -> dict[str, str | None]:
    """Return the checks that fail, each with the first failure that it names."""
    return {name: check.first for name, check in checks(path).items() if check.failures}


def altered(path: Path, statement: str) -> None:
    with closing(sqlite3.connect(path)) as plain, plain:
        plain.execute("PRAGMA foreign_keys = OFF")
        first, *others = statement.split(";")
        assert plain.execute(first).rowcount > 0
        for each in others:
            plain.execute(each)


def test_a_file_with_rows_in_every_table_is_sound(sound, cli):
    assert found_wrong(sound) == {}
    listed = cli("births", "--deaths", "--json", "--db", str(sound))
    assert (listed.code, listed.out) == (0, "[]\n")  # nothing of the unfinished period


def test_only_births_of_chosen_periods_are_checked_again(sound):
    of_them = "SELECT count(*) FROM change JOIN cycle ON id = cycle WHERE p BETWEEN 4 AND 6"
    ((rows,),) = ask(sound, of_them)
    assert checks(sound, Selection(periods=((4, 6),)))["changes"].rows == rows > 2
    assert checks(sound, Selection(periods=((4, 6),)), sample=rows - 1)["changes"].rows == rows - 1


@pytest.mark.parametrize(
    ("change", "allowed"),
    [
        ("windows = windows + 3, undecided = undecided + 3", True),
        ("lower = lower - 1e-6, upper = upper + 1e-6", True),
        ("windows = windows - 1, lower = lower - 1e-6", False),
        ("undecided = undecided - 1", False),
        ("lower = lower + 1e-6", False),
        ("lower = lower - 1e-6, upper = upper - 1e-6", False),
    ],
)
def test_bounds_by_balls_may_be_weaker_but_not_stronger(sound, tmp_path, monkeypatch, change, allowed):
    for proof, right in (("balls", allowed), ("doubles", False)):
        path = Path(shutil.copy(sound, tmp_path / "altered.db"))
        altered(path, f"UPDATE entropy_bound SET {change} WHERE edges = 5 AND proof = '{proof}'")
        assert ("entropy" not in found_wrong(path)) == right
    # longer windows would take hours
    monkeypatch.setattr("orbitdb.verification.levels_and_bounds.RECOUNTED", 10)
    assert "entropy" not in found_wrong(tmp_path / "altered.db")


def test_a_file_with_levels_is_sound(sound_levels):
    assert found_wrong(sound_levels) == {}


@pytest.mark.parametrize("name", ["fill", "births", "sweep", "bounds", "verify --rigorous"])
def test_rows_attributed_to_the_wrong_command_are_found(sound, tmp_path, name):
    path = Path(shutil.copy(sound, tmp_path / "altered.db"))
    altered(path, f"""UPDATE run SET parameters = replace(parameters, '"{name}"', '"simulate"')""")
    with reading(path) as moment:
        wrong = [check.first for check in check_provenance(moment.connection) if check.failures]
    assert wrong


@pytest.mark.parametrize(
    "change", ["started = 'once'", "version = ''", "parameters = 'no JSON'", "parameters = '[]'"]
)
def test_only_the_run_without_provenance_is_named(sound, tmp_path, change):
    path = Path(shutil.copy(sound, tmp_path / "altered.db"))
    altered(path, f"UPDATE run SET {change} WHERE id = 1")
    with reading(path) as moment:
        wrong = next(check for check in check_provenance(moment.connection) if check.failures)
    assert (wrong.failures, wrong.first) == (1, "run 1")


@pytest.mark.parametrize("name", ALTERATIONS)
def test_every_alteration_by_hand_is_found(request, tmp_path, name):
    statement, check = ALTERATIONS[name]
    source = request.getfixturevalue("sound_levels" if name.startswith("level") else "sound")
    path = Path(shutil.copy(source, tmp_path / "altered.db"))
    altered(path, statement)
    wrong = found_wrong(path)
    assert check in wrong
    assert wrong[check]
