"""``orbitdb sweep``, and what other commands say of periods that were swept and not filled."""

import json
import sqlite3
from contextlib import closing

import pytest

KEYS = ["p", "N_t", "N_c", "classes", "boundary", "unresolved", "seconds", "processor_seconds"]


def test_other_commands_answer_from_sweeps(cli):
    planned = cli("sweep", "--p", "6", "--dry-run")
    assert planned.err.startswith("p = 2..6 at a = 1.6: 389 sequences to come, under a second, in ")
    assert planned.out == ""
    swept = cli("sweep", "--p", "6", "--json")
    rows = json.loads(swept.out)
    assert [list(row) for row in rows] == [KEYS] * 5
    assert [rows[-1][key] for key in KEYS[:6]] == [6, 252, 188, 39, 0, 0]
    assert swept.err.startswith("p = 2..6 at a = 1.6: 389 sequences, ")
    commands = (("table",), ("entropy",), ("lyapunov", "--weight", "det"))
    before = [cli(*command, "--json") for command in commands]
    source = "periods 2-6 at a = 1.6: from a sweep, their rows are not stored\n"
    assert all(outcome.code == 0 and source in outcome.err for outcome in before)
    assert cli("lyapunov", "--cut", "9").code == 1
    cli("fill", "--p", "5")
    assert "period 6 at a = 1.6: from a sweep" in cli("lyapunov").err
    cli("fill", "--p", "6")
    for command, old in zip(commands, before, strict=True):
        new = cli(*command, "--json")
        assert "sweep" not in new.err
        for row, stored in zip(json.loads(old.out), json.loads(new.out), strict=True):
            close = {key: value and pytest.approx(value, rel=1e-12) for key, value in stored.items()}
            assert row == close


CHANGES = [
    ("n_c = n_c - 2, classes = classes - 1", "sweeps", "n_c is 78 instead of 80"),
    ("sums = CAST(substr(sums, 1, length(sums) - 8) || zeroblob(8) AS BLOB)", "sums", ""),
    ("words = words - 2", "sweeps", "94 sequences instead of 96"),
    ("sums = x'00'", "sweeps", ""),
]


@pytest.mark.parametrize("changes", [CHANGES[:1], pytest.param(CHANGES[1:], marks=pytest.mark.slow)])
def test_what_is_swept_is_told_and_verified(cli, tmp_path, changes):
    """A file that has sweeps alone is checked; counts and sums that were altered are found."""
    cli("sweep", "--p", "5")
    cli("sweep", "--p", "4", "--a", "1")
    rows = json.loads(cli("info", "--json").out)
    assert [(row["a"], row["p"], row["state"]) for row in rows] == [
        (a, p, "swept") for a, most in ((1.0, 4), (1.6, 5)) for p in range(2, most + 1)
    ]
    assert [rows[-1][key] for key in ("stored", "N_t", "N_c", "boundary", "storing")] == [0, 96, 80, 0, None]
    sound = cli("verify", "--p", "2-5", "--a", "1.6", "--json")
    assert (sound.code, sound.err.split(" all is well")[0]) == (0, f"{tmp_path / 'orbits.db'}:")
    assert [(row["check"], row["rows"]) for row in json.loads(sound.out)[-2:]] == [("sweeps", 4), ("sums", 4)]
    for change, check, first in changes:
        with closing(sqlite3.connect(tmp_path / "orbits.db")) as plain:
            before = plain.execute("SELECT * FROM sweep").fetchall()
            plain.execute(f"UPDATE sweep SET {change} WHERE p = 5")
            plain.commit()
            found = cli("verify", "--a", "1.6", "--p", "5", "--json")
            plain.execute("DELETE FROM sweep")
            plain.executemany(f"INSERT INTO sweep VALUES ({','.join('?' * len(before[0]))})", before)
            plain.commit()
        failing = {row["check"]: row["first"] for row in json.loads(found.out) if row["failures"]}
        assert (found.code, list(failing)) == (1, [check])
        assert first in failing[check]


def test_what_cannot_be_swept(cli):
    for wrong in (["21"], ["1"], ["x"], ["3", "--a", "0"], ["3", "--jobs", "0"]):
        outcome = cli("sweep", "--p", *wrong)
        assert (outcome.code, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)
