"""Certificates: what they prove, which rows get none, and how certification resumes."""

import json

import numpy as np
import pytest
from contents import alter, ask
from quick import slow_but
from reference import refine

from orbitdb.selection import Selection
from orbitdb.verification.check_orbits import certify
from orbitdb.verification.verify import report

CLASSES = 498
"""Number of classes with p = 2..8."""


@pytest.mark.parametrize("step", slow_but([3], [1, 3]))
def test_certified_radii_are_between_the_true_error_and_the_stored_bound(small, cli, step):
    """The radius is between the true error, from 50 digits and plane geometry, and the stored bound."""
    outcome = cli("verify", "--prove", "--a", "1.6", "--json")
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


def test_rows_at_every_a_get_certificates(small, cli):
    assert cli("verify", "--prove", "--p", "6", "--time-reversal", "self").code == 0
    query = "SELECT a, count(*) FROM certificate JOIN stadium ON id = stadium GROUP BY a"
    assert ask(small, query) == [(1.0, 3), (1.6, 3)]


@pytest.mark.slow
def test_orbits_through_a_joint_are_certified(small, cli):
    assert cli("verify", "--prove", "--a", "1").code == 0
    query = "SELECT count(*) FROM orbit JOIN certificate USING (stadium, cycle) WHERE status = 'boundary'"
    assert ask(small, query)[0][0] > 0


@pytest.mark.slow
def test_certification_resumes_where_it_stopped(filled):
    steps = certify(filled, Selection())
    first = next(steps)
    steps.close()
    kept = ask(filled, "SELECT cycle, radius, run FROM certificate ORDER BY cycle")
    assert len(kept) == first.done == first.checks[0].rows
    assert 0 < len(kept) < CLASSES
    (rest,) = report(certify(filled, Selection()))
    assert rest.rows == CLASSES - len(kept)
    assert report(certify(filled, Selection())) == []
    assert ask(filled, "SELECT count(*) FROM certificate") == [(CLASSES,)]
    assert ask(filled, "SELECT cycle, radius, run FROM certificate ORDER BY cycle")[: len(kept)] == kept


def test_an_altered_row_gets_no_certificate(small, cli):
    ((cycle, word),) = ask(small, "SELECT id, word FROM cycle WHERE p = 5 ORDER BY id LIMIT 1")
    alter(small, f"UPDATE orbit SET lyapunov = lyapunov + 3 * lyapunov_error WHERE cycle = {cycle}")
    outcome = cli("verify", "--prove", "--p", "5", "--a", "1.6", "--json")
    assert outcome.code == 1
    failing = {row["check"]: row for row in json.loads(outcome.out) if row["failures"]}
    assert failing["certificates"]["failures"] == 1
    assert failing["certificates"]["first"] == f"{word} at a = 1.6"
    assert ask(small, f"SELECT count(*) FROM certificate WHERE cycle = {cycle}") == [(0,)]
