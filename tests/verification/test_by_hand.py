"""`verify` finds a wrong value of each kind that a person relies on, in a file that is otherwise sound."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from contents import ask, checks

from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.verification.verify import verify

pytestmark = pytest.mark.slow

BORN_LATE = "(SELECT cycle FROM change WHERE a > 0 ORDER BY cycle LIMIT 1)"
ORBIT = "(SELECT min(cycle) FROM orbit WHERE status = 'orbit' AND stadium = 1 AND cycle > 0)"
PRUNED = "(SELECT min(cycle) FROM orbit WHERE status = 'dynamical' AND stadium = 1)"
EIGHT = "(SELECT max(id) FROM cycle WHERE p = 7 AND class_size = 8)"

ALTERATIONS = {
    "a reference to nothing": (f"UPDATE orbit SET run = 99 WHERE cycle = {ORBIT}", "file"),
    "coordinates cut short": (
        f"UPDATE orbit SET coordinates = substr(coordinates, 9) WHERE cycle = {ORBIT}", "file"),
    "a text that is no word": (f"UPDATE cycle SET word = '013x' WHERE id = {EIGHT}", "file"),
    "a missing class": (
        f"DELETE FROM orbit WHERE cycle = {0o101023}; DELETE FROM certificate WHERE cycle > {0o101023};"
        f"DELETE FROM cycle WHERE id = {0o101023}", "counts"),
    "a missing row": (f"DELETE FROM orbit WHERE cycle = {ORBIT}", "counts"),
    "the number of orbits": ("UPDATE fill SET n_c = n_c - 1 WHERE p = 5", "counts"),
    "a rule's number": ("UPDATE fill SET rule_4 = rule_4 + 1 WHERE p = 5", "counts"),
    "the words of an unfinished period": (
        "UPDATE fill SET state = 'filling', words = words - 1 WHERE p = 5", "counts"),
    "an unfinished period of births": (
        f"UPDATE birth_fill SET state = 'filling' WHERE p = 7; DELETE FROM change WHERE cycle = {EIGHT}",
        "births"),
    "the walls of a class": (f"UPDATE cycle SET walls = walls + 1 WHERE id = {EIGHT}", "classes"),
    "the size of a class": (f"UPDATE cycle SET class_size = 4 WHERE id = {EIGHT}", "classes"),
    "the words of a class": (
        f"UPDATE cycle SET words = substr(words, 1, 7 * p) WHERE id = {EIGHT}", "classes"),
    "another representative": (
        f"UPDATE cycle SET word = substr(words, 1 + p, p) WHERE id = {EIGHT}", "classes"),
    "a class stored twice": (
        "INSERT INTO cycle SELECT id + 1, p, substr(words, 1 + p, p), class_size, walls, time_reversal,"
        f" symmetry, words FROM cycle WHERE id = {EIGHT}", "classes"),
    "the rules of a pruned word": ("UPDATE pruned SET rules = '2' WHERE word = '001'", "classes"),
    "a pruned word that is none": (f"INSERT INTO pruned VALUES ({-0o10013}, 4, '0013', '')", "classes"),
    "a status": (f"UPDATE orbit SET status = 'boundary' WHERE cycle = {ORBIT}", "statuses"),
    "an undecided word": (f"UPDATE orbit SET status = 'unresolved' WHERE cycle = {PRUNED}", "statuses"),
    "the side of a margin": (f"UPDATE orbit SET margin = -margin WHERE cycle = {PRUNED}", "statuses"),
    "a length beyond its bound": (
        f"UPDATE orbit SET length = length * (1 + 1e-12) WHERE cycle = {ORBIT}", "bounds"),
    "a missing length": (f"UPDATE orbit SET length = NULL WHERE cycle = {ORBIT}", "bounds"),
    "a lambda": (f"UPDATE orbit SET lyapunov = lyapunov + 1e-10 WHERE cycle = {ORBIT}", "Hessian"),
    "a margin": (f"UPDATE orbit SET margin = margin + 1e-9 WHERE cycle = {ORBIT}", "walls"),
    "a birth": (f"UPDATE change SET a = a * 1.001 WHERE cycle = {BORN_LATE}", "births"),
    "a bracket": (f"UPDATE change SET error = 1e-30 WHERE cycle = {BORN_LATE}", "births"),
    "a birth called a death": (f"UPDATE change SET kind = 'died' WHERE cycle = {BORN_LATE}", "births"),
    "the largest birth": ("UPDATE birth_fill SET largest = largest + 1 WHERE p = 7", "births"),
    "the orbits of a sweep": ("UPDATE sweep SET n_c = n_c - 1 WHERE p = 7", "sweeps"),
    "a level": ("UPDATE level SET k = k + 1e-8 WHERE number = 1", "levels"),
    "the levels below a window": ("UPDATE level_fill SET below = below + 1", "levels"),
    "a missing level": ("DELETE FROM level WHERE number = (SELECT max(number) FROM level)", "levels"),
}  # fmt: skip
"""By name, the statements that alter the file, and the check that must fail."""


def test_only_births_of_chosen_periods_are_checked_again(files):
    of_them = "SELECT count(*) FROM change JOIN cycle ON id = cycle WHERE p BETWEEN 4 AND 6"
    ((rows,),) = ask(files["whole"], of_them)
    found = checks(files["whole"], Selection(periods=((4, 6),)))["births"]
    assert found.rows == rows + 3  # and the counts of three fills
    assert not found.failures


def test_levels_are_checked_at_the_chosen_a_unless_words_are_chosen(files, cli):
    db = ["--db", str(files["levels"])]
    nothing = cli("verify", "--p", "2-4", "--json", *db)
    assert nothing.code == 1
    assert "levels" not in nothing.out
    assert "1 quantum level" in cli("verify", *db).err
    for other in (Selection(1.0), Selection(periods=((2, 4),)), Selection(where="length < 9")):
        assert "levels" not in checks(files["levels"], other)
    assert checks(files["levels"], Selection(1.6))["levels"].rows > 0


@pytest.mark.parametrize("name", ALTERATIONS)
def test_every_alteration_is_found(files, tmp_path, name):
    statement, check = ALTERATIONS[name]
    path = Path(shutil.copy(files["levels" if "level" in name else "whole"], tmp_path / "altered.db"))
    with closing(sqlite3.connect(path)) as plain, plain:
        plain.execute("PRAGMA foreign_keys = OFF")
        first, *others = statement.split(";")
        assert plain.execute(first).rowcount > 0
        for each in others:
            plain.execute(each)
    with reading(path) as connection, closing(verify(connection, [Selection()])) as steps:
        assert any(found.name == check and found.failures for step in steps for found in step.checks)
