"""``orbitdb sweep``, and what other commands say of periods that were swept and not filled."""

import json

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
            close = {key: value and pytest.approx(value, rel=1e-6) for key, value in stored.items()}
            assert row == close


def test_what_cannot_be_swept(cli):
    for wrong in (["21"], ["1"], ["x"], ["3", "--a", "0"], ["3", "--jobs", "0"]):
        outcome = cli("sweep", "--p", *wrong)
        assert (outcome.code, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)
