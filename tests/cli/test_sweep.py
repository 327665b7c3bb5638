"""``orbitdb sweep``, and what other commands say of periods that were swept and not filled."""

import json

import pytest

KEYS = ["p", "N_t", "N_c", "classes", "boundary", "unresolved", "seconds", "processor_seconds"]


def test_other_commands_answer_from_sweeps(cli):
    planned = cli("sweep", "--p", "7", "--dry-run")
    assert planned.err.startswith("p = 2..7 at a = 1.6: 1101 sequences to come, under a second, in ")
    assert planned.out == ""
    swept = cli("sweep", "--p", "7", "--json")
    rows = json.loads(swept.out)
    assert [list(row) for row in rows] == [KEYS] * 6
    assert [rows[-1][key] for key in KEYS[:6]] == [7, 712, 376, 59, 0, 0]
    assert swept.err.startswith("p = 2..7 at a = 1.6: 1101 sequences, ")
    commands = (("table",), ("entropy",), ("lyapunov",), ("lyapunov", "--weight", "det"))
    before = [cli(*command, "--json") for command in commands]
    source = "periods 2-7 at a = 1.6: from a sweep, their rows are not stored\n"
    assert all(outcome.code == 0 and source in outcome.err for outcome in before)
    assert cli("lyapunov", "--cut", "9").code == 1
    cli("fill", "--p", "5")
    assert "periods 6-7 at a = 1.6: from a sweep" in cli("lyapunov").err
    cli("fill", "--p", "7")
    for command, old in zip(commands, before, strict=True):
        new = cli(*command, "--json")
        assert "sweep" not in new.err
        for row, stored in zip(json.loads(old.out), json.loads(new.out), strict=True):
            same = {key: row[key] for key in row if not key.endswith(("_sum_rule", "_error"))}
            assert same == {key: pytest.approx(stored[key], rel=1e-12) for key in same if same[key]} | {
                key: stored[key] for key in same if not same[key]
            }


def test_what_cannot_be_swept(cli):
    for wrong in (
        ["--p", "21"],
        ["--p", "1"],
        ["--p", "x"],
        ["--p", "3", "--a", "0"],
        ["--p", "3", "--jobs", "0"],
    ):
        outcome = cli("sweep", *wrong)
        assert (outcome.code, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)
